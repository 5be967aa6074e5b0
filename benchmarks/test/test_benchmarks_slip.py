"""Part slip: small numbers of runs within the limits, the measured stop, and the manoeuvres of the tables."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.measured import BMW, data_directory
from benchmarks.protocol import DT
from benchmarks.runner import failures
from benchmarks.slip import part as slip
from benchmarks.slip.car_drives import cases, deviates, drive
from benchmarks.slip.consistency import Judged, case_rows, judge
from benchmarks.slip.stops import CAR, CRUISE, Stop, follow, follow_bmw, shipped, stops
from vehicle_models.vehicle_file import load_vehicle

needs_data = pytest.mark.skipif(
    not (data_directory() / BMW).is_file(), reason=f"measured data are absent: {data_directory()} (set FRICTION_DATA)"
)


def test_stop_begins_with_a_steady_cruise_and_ends_at_3_metres_a_second() -> None:
    (stop,) = stops("dry", range(1))
    assert stop.onset == round(CRUISE / DT)
    assert np.max(np.abs(stop.speed[: stop.onset] - 30.0)) < 0.1
    assert 3.0 < stop.speed[-1] < 3.1
    assert stop.slip[stop.onset :].max() > 0.1
    noise = stop.wheel_speed - (1.0 - stop.slip) * stop.speed[:, np.newaxis] / np.array(CAR.radii)
    assert noise.std() == pytest.approx(np.sqrt(0.005), rel=0.05)


@pytest.mark.parametrize(
    "name",
    [
        "burckhardt, dry, through the peak",
        "pacejka, wet, at 50% of the peak",
        "step of +10 %, coasting",
        "driven wheels spin on snow, pacejka",
    ],
)
def test_stated_deviations_hold_on_a_car_that_only_its_vehicle_file_describes(name: str) -> None:
    car = load_vehicle("compact_car")
    found = judge(drive(cases()[name], car, 1), car, shipped().estimator)
    assert np.mean(np.abs(found.speed) < 1.96 * found.speed_deviation) > 0.9
    assert np.mean(np.abs(found.slip) < 1.96 * found.slip_deviation) > 0.9
    assert found.valid > 80.0


@pytest.mark.parametrize("name", ["step of +10 %, through the peak", "step of -10 %, through the peak"])
def test_deviations_hold_over_steps_of_slope_in_hard_stops(name: str) -> None:
    car = load_vehicle("compact_car")
    runs = [judge(drive(cases()[name], car, seed), car, shipped().estimator) for seed in range(8)]
    assert failures(case_rows(name, runs)) == []


@pytest.mark.parametrize(
    ("error", "failing"),
    [(0.3, ["z of the speed, RMS, not less"]), (0.5, []), (1.2, []), (1.4, ["z of the speed, RMS"])],
)
def test_deviations_that_are_too_large_fail_as_those_that_are_too_small(error: float, failing: list[str]) -> None:
    errors, deviations = np.full(10, error), np.ones(10)
    rows = case_rows("any", [Judged(errors, deviations, errors, deviations, 97.0)])
    assert [row["quantity"] for row in failures(rows)] == failing


@pytest.mark.parametrize(("first", "count"), [(0, 4), (57, 4), (100, 6), (1000, 8)])
def test_a_few_cars_differ_from_their_vehicle_file_by_as_much_as_it_states(first: int, count: int) -> None:
    radii = [deviates(seed)["radius"] for seed in range(first, first + count)]
    assert 0.75 < np.sqrt(np.mean(np.square(radii))) < 1.3
    assert abs(np.mean(radii)) < 0.5


@pytest.mark.parametrize("road", ["dry", "snow"])
def test_stops_are_within_the_limits_and_far_better_than_the_best_wheel(road: str) -> None:
    found = [follow(stop) for stop in stops(road, range(1))]
    ours, baseline = slip._rows(road, found)
    judged = slip._judged([ours, baseline])
    assert [row["quantity"] for row in judged] == ["speed_rms", "slip_rms"]
    assert failures(judged) == []
    assert baseline["speed_rms"] > 4.0 * ours["speed_rms"]


def test_the_order_of_the_wheels_in_the_vehicle_file_does_not_matter() -> None:
    car = load_vehicle("bmw_m8")
    acceleration = np.where(np.arange(600) < 400, 0.0, -4.0)
    speed = 30.0 + DT * np.cumsum(acceleration)
    measured = speed[:, np.newaxis] / np.array(car.radii)
    stop = Stop(400, measured, acceleration, speed, np.zeros((600, 4)))
    turned = replace(car, wheels=car.wheels[::-1])
    found = follow(stop, turned)
    np.testing.assert_array_equal(found.slip, follow(stop, car).slip)
    assert np.abs(found.slip[-1]).max() < 0.02


def test_a_car_that_no_engine_drives_cannot_cruise() -> None:
    with pytest.raises(ValueError, match="driven"):
        stops("dry", range(1), vehicle=load_vehicle("chapter_car"))


@needs_data
def test_measured_stop_is_within_the_limits_and_an_offset_does_not_matter() -> None:
    (plain, baseline), (shifted, _) = (
        slip._rows("bmw", [follow_bmw(data_directory() / BMW, offset)]) for offset in (0.0, 0.35)
    )
    assert plain["speed_rms"] <= 0.05
    assert plain["slip_rms"] <= 0.006
    assert abs(shifted["speed_rms"] - plain["speed_rms"]) <= 0.02
    assert baseline["speed_rms"] > 0.3
    assert plain["valid"] > 0.95
