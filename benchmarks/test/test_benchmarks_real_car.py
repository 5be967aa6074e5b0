"""Friction curves of cars that are not known exactly: what is counted as what."""

import argparse
from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.real_car import part
from benchmarks.real_car.bound import Bound, _burckhardt, _correlation, _pacejka, _sensitivities, bound
from benchmarks.real_car.driving import (
    Across,
    Drive,
    DriveResult,
    SlopeDrive,
    drive_rows,
    record_drive,
    sensor_messages,
    slope_drive_rows,
)
from benchmarks.real_car.part import NOMINAL_CAR, PERTURBATIONS, perturbed_car
from benchmarks.real_car.road_change import TwoRoads, TwoRoadsResult, make_two_roads, rise_rows, two_roads_rows
from benchmarks.real_car.stops import VEHICLE, Answers, judge, stop_rows
from benchmarks.runner import Row, run_lengths
from corner_sim.car.car import load_variation
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES, Burckhardt, Pacejka
from friction_runtime.lateral_inputs import MEASURED, LateralInput
from vehicle_models.surfaces import TABLE_8_1
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def run() -> Recording:
    parameters, cycling = perturbed_car("none", "dry")
    return record(parameters, SlipCycle(parameters, cycling), 1)


def first_passing(run: Recording) -> float:
    return float(run.time[(run.tyre_slip > run.lambda_max).any(axis=1).argmax()])


def exact(run: Recording, since: float = 0.1, alarm_shift: float = 0.0) -> Answers:
    """Right answers, valid `since` the first passing, with alarms `alarm_shift` after the truth."""
    n = len(run.time)
    every = np.ones((n, 4))
    shift = round(alarm_shift / float(run.time[1]))
    beyond = np.roll(run.tyre_slip > run.lambda_max, shift, axis=0).astype(np.float64)
    beyond[: max(shift, 0)] = 0.0  # the end that has come round
    valid = every * (run.time >= first_passing(run) + since - 1e-9)[:, np.newaxis]
    return Answers(
        every * run.lambda_max, every * 0.01, every * run.mu_max, every * 0.01, beyond, valid, valid, 0.0 * every
    )


def quantities(rows: list[Row]) -> dict[str, Row]:
    return {row["quantity"]: row for row in rows}


def test_right_answers_pass_every_limit(run: Recording) -> None:
    result = judge(run, exact(run), first_passing(run))
    assert result.first_valid == pytest.approx(0.1, abs=1e-6)
    assert (result.passed, result.early, result.missed, result.false_beyond) == (4, 0, 0, 0.0)
    rows = stop_rows("case", "dry", [result] * 3, judge_errors=True)
    assert all(row["passed"] in (None, True) for row in rows)
    assert quantities(rows)["coverage of lambda_max [%]"]["estimates"] == 12


def test_an_interval_that_misses_the_truth_is_counted(run: Recording) -> None:
    found = exact(run)
    wrong = judge(run, replace(found, lambda_max=found.lambda_max + 0.03), first_passing(run))
    rows = quantities(stop_rows("case", "dry", [judge(run, found, first_passing(run)), wrong], judge_errors=False))
    assert rows["coverage of lambda_max [%]"]["value"] == 50.0
    assert rows["coverage of lambda_max [%]"]["bias_pct"] == pytest.approx(50.0 * 0.03 / run.lambda_max[0])
    assert rows["coverage of lambda_max, all valid messages [%]"]["value"] == 50.0
    assert rows["coverage of mu_max [%]"]["value"] == 100.0


def test_silence_does_not_pass(run: Recording) -> None:
    found = exact(run)
    silent = replace(found, valid=0.0 * found.valid, probability_beyond_peak=found.valid * np.nan)
    result = judge(run, silent, first_passing(run))
    assert result.missed == 4 and result.first_valid == np.inf
    rows = quantities(stop_rows("case", "dry", [result], judge_errors=False))
    assert not rows["valid within 0.4 s [%]"]["passed"]
    assert not rows["coverage of lambda_max [%]"]["passed"]


@pytest.mark.parametrize(("shift", "early"), [(-0.05, 4), (-0.02, 0), (0.1, 0)])
def test_alarms_more_than_25_ms_before_the_passing_are_early(run: Recording, shift: float, early: int) -> None:
    result = judge(run, exact(run, alarm_shift=shift), first_passing(run))
    assert result.early == early and result.missed == 0
    if not early:
        assert result.alarm_delay == pytest.approx([shift] * 4, abs=0.003)
    assert (result.false_beyond > 0.0) == (abs(shift) > 0.025)


def test_what_is_valid_before_50_ms_fails(run: Recording) -> None:
    rows = stop_rows("case", "dry", [judge(run, exact(run, since=0.04), first_passing(run))], judge_errors=False)
    assert not quantities(rows)["valid before 0.05 s [%]"]["passed"]


@pytest.mark.parametrize("perturbation", PERTURBATIONS)
def test_a_perturbation_is_alone(perturbation: str) -> None:
    (car, cycling), (none, plain) = (perturbed_car(each, "snow") for each in (perturbation, "none"))
    assert none == replace(NOMINAL_CAR, tyres=(TYRES["burckhardt"]["snow"],) * 4)
    changed = {each.name for each in fields(car) if getattr(car, each.name) != getattr(none, each.name)}
    assert len(changed) + (cycling != plain) == (perturbation != "none")


def test_the_car_without_perturbation_is_that_of_the_vehicle_file() -> None:
    car, vehicle = NOMINAL_CAR, load_vehicle(VEHICLE)
    for name in ("mass", "front_load_share", "wheelbase", "track", "drag_area", "rolling_resistance"):
        assert getattr(car, name) == getattr(vehicle, name), name
    for name in ("radius", "inertia", "brake_gain", "relaxation_length"):
        assert getattr(car, name) == tuple(getattr(wheel, name) for wheel in vehicle.wheels), name
    assert {car.sensors.encoder_teeth} == {wheel.encoder_teeth for wheel in vehicle.wheels}
    assert (car.height, car.engine_drag) == (vehicle.centre_of_gravity_height, vehicle.engine_drag_torque)
    assert (car.pitch_gain, car.sensors.acceleration_delay) == (
        vehicle.accelerometer.pitch_gain,
        vehicle.accelerometer.delay,
    )
    assert car.sensors.pressure_delay == vehicle.brake_pressure_delay


def test_runs_are_counted_by_wheel() -> None:
    true = np.array([[1, 0], [1, 1], [0, 1], [1, 0]], dtype=bool)
    assert sorted(run_lengths(true)) == [1, 2, 2]
    assert len(run_lengths(np.zeros((5, 4), dtype=bool))) == 0


def test_a_claim_in_ordinary_driving_fails() -> None:
    quiet, loud = DriveResult(1.0, 0, 0, 0.3), DriveResult(1.0, 1, 0, 0.3)
    assert all(row["passed"] in (None, True) for row in drive_rows([quiet]))
    assert [row["quantity"] for row in drive_rows([quiet, loud]) if row["passed"] is False] == ["valid peaks"]


def test_a_lasting_slope_sign_in_ordinary_driving_fails() -> None:
    quiet = SlopeDrive(1.0, {"slip": 0, "no_slip": 0}, {"slip": 0, "no_slip": 0}, {"slip": 0.0, "no_slip": 0.02})
    loud = replace(quiet, lasting={"slip": 1, "no_slip": 0})
    assert all(row["passed"] in (None, True) for row in slope_drive_rows([quiet]))
    failed = [row for row in slope_drive_rows([quiet, loud]) if row["passed"] is False]
    assert [row["case"] for row in failed] == ["ordinary driving, friction_slope slip"]


def test_what_stays_valid_and_wrong_on_a_new_road_fails() -> None:
    silent = TwoRoadsResult(10, 10, 10, 10, 0.05, np.inf)
    late = TwoRoadsResult(10, 30, 12, 12, 0.4, np.inf)
    assert all(row["passed"] in (None, True) for row in two_roads_rows(("dry", "snow"), False, [silent] * 10))
    rows = quantities(two_roads_rows(("dry", "snow"), False, [silent, late]))
    assert not rows["valid and wrong later than 0.1 s [% of stops]"]["passed"]
    assert not rows["coverage of mu_max, all valid messages [%]"]["passed"]
    nothing = TwoRoadsResult(0, 0, 0, 0, 0.0, np.inf)
    assert all(row["passed"] in (None, True) for row in two_roads_rows(("dry", "wet"), True, [nothing]))


def test_snow_after_dry_is_never_valid_with_the_peak_of_dry() -> None:
    found = make_two_roads(TwoRoads(77_001, ("dry", "snow"), False, "burckhardt"))
    assert found.last_old < 0.1


def test_mu_max_that_is_not_given_before_the_peak_is_not_covered() -> None:
    rows = quantities(rise_rows("pacejka", [(0.5, 0.1, True), (0.5, float("nan"), False)]))
    assert rows["coverage of mu_max at 50 % of it [%]"]["value"] == 50.0
    assert rows["median |error| of mu_max at 50 % of it [%]"]["value"] == pytest.approx(10.0)


def test_shapes_of_the_bound_are_those_of_the_tyres() -> None:
    x = np.linspace(0.0, 3.0, 50)
    dry, snow = TYRES["burckhardt"]["dry"], TYRES["pacejka"]["snow"]
    assert isinstance(dry, Burckhardt) and isinstance(snow, Pacejka)
    for tyre, shape in (
        (dry, _burckhardt(x, dry.th2 * dry.peak[0])),
        (snow, _pacejka(x, snow.C, snow.E)),
    ):
        friction = np.array([tyre.friction(tyre.peak[0] * each)[0] for each in x])
        np.testing.assert_allclose(tyre.peak[1] * shape, friction, atol=1e-9)


def test_the_load_of_the_bound_has_the_correlation_of_the_road() -> None:
    load = np.array(load_variation(0.05, 1, 1e-3))[:, 0] - 1.0
    time = np.array([0.0, 0.01, 0.03, 0.1])
    measured = [np.mean(load * np.roll(load, round(1e3 * lag))) / np.mean(load**2) for lag in time]
    np.testing.assert_allclose(_correlation(time)[0], measured, atol=0.02)


def test_torques_and_forces_of_the_bound_are_those_of_the_plant() -> None:
    car, _ = perturbed_car("none", "dry")
    car = replace(car, sensors=replace(car.sensors, sample_rate=1000))
    run = record(car, SlipCycle(car, Cycling()), 1)
    n = int(np.searchsorted(run.time, first_passing(run) + 0.4))
    wheels, balance = _sensitivities(run, n)
    braked = slice(int(np.searchsorted(run.time, 0.75)), n)
    torque = wheels["ln gain front"][braked, 0]
    pressure = run.brake_pressure[braked, 0] * car.brake_gain[0]
    assert np.corrcoef(torque, pressure)[0, 1] > 0.999
    # forces over the mass are what slows the car, but for rolling and air
    slowed = -balance["ln mass"][braked] + 0.012 * 9.81 + 0.5 * 1.2 * 0.65 * run.speed[braked] ** 2 / 1500.0
    apart = slowed + run.true_acceleration[braked]  # which is a mean over the last millisecond
    assert np.abs(apart).mean() < 0.05 and abs(apart.mean()) < 0.01


def test_a_bound_is_a_few_percent_and_snow_leaves_most() -> None:
    dry, snow = (bound(Bound(7, road, "burckhardt")) for road in ("dry", "snow"))
    assert 0.003 < dry[0] < 0.05 and 0.001 < dry[1] < 0.02
    assert snow[0] > dry[0] and snow[1] > dry[1]


def test_hours_made_in_parts_are_those_made_at_once() -> None:
    whole = part.drives(0.2, 1)
    assert sum(drive.duration for drive in whole) == pytest.approx(720.0)
    assert part.drives(0.1, 1) + part.drives(0.1, 4) == whole
    assert min(drive.duration for drive in part.drives(2.2, 1)) == 120.0, "no drive of a rounding error"


def test_the_part_makes_all_its_studies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "ROADS", ("wet",))
    monkeypatch.setattr(part, "CHANGES", (("dry", "wet"),))
    monkeypatch.setattr(part, "SPLITS", ())
    monkeypatch.setattr(part, "STARTS", ("pacejka snow",))
    parser = argparse.ArgumentParser()
    part.add_arguments(parser)
    arguments = ["--seeds", "1", "--hours", "0.002", "--perturbations", "48 teeth at 100 Hz"]
    rows = part.run(parser.parse_args([*arguments, "--cases", "held 0.6 g", "shallow, wet 0.5 g"]))
    assert {row["case"] for row in rows} == {
        *("48 teeth at 100 Hz", "random cars", "ordinary driving"),
        *("before the peak, burckhardt", "before the peak, pacejka"),
        *("known exactly", "cost"),
        *("held 0.6 g", "shallow, wet 0.5 g", "traction, pacejka snow"),
        *("road change", "ordinary driving, friction_slope slip", "ordinary driving, friction_slope no_slip"),
    }
    assert {row["road"] for row in rows} == {"wet", "all", "dry to wet", *TABLE_8_1}
    for row in rows:
        assert {"value", "limit", "passed"} <= set(row)


@pytest.mark.parametrize("across", Across)
def test_imus_that_do_not_turn_are_seen_as_such(across: Across) -> None:
    drive = Drive(1, "dry", "burckhardt", across, duration=2.0)
    run, vehicle = record_drive(drive), load_vehicle(VEHICLE)
    lateral = LateralInput(vehicle.accelerometer)
    read = [lateral.read(dict(sample)["imu/data"]) for sample in sensor_messages(run, vehicle, drive)]
    assert len(read) == len(run.time)
    assert all((found[-1] == MEASURED) is (across is Across.MEASURED) for found in read)
    if across is Across.MEASURED:
        turning = np.array(read)[:, 1] - run.yaw_rate
        assert np.std(turning) < 0.01
