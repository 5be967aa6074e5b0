"""Whole-vehicle mode: recovers a curve from deceleration and slips, gives honest uncertainties, survives garbage."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from friction_curve_id.vehicle.vehicle_samples import (
    VehiclePoint,
    VehicleSample,
    VehicleSamples,
    WholeVehicleParameters,
    relaxation_spread,
)
from friction_curve_id.vehicle.whole_vehicle import WholeVehicle
from friction_parameters.parameter import ParameterError, from_mapping
from vehicle_models import burckhardt
from vehicle_models.constants import AIR_DENSITY
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("bmw_m8")
DEFAULT = WholeVehicleParameters()
STEP = 0.01


def with_relaxation(*lengths: float) -> Vehicle:
    return replace(
        CAR,
        wheels=tuple(replace(w, relaxation_length=each) for w, each in zip(CAR.wheels, lengths, strict=True)),
    )


def stop(
    name: str = "high_grip", seed: int = 0, noise: float = 0.02, shift: float = 0.0, car: Vehicle = CAR
) -> list[VehicleSample]:
    """A stop from 40 m/s in which every wheel cycles between rolling and far beyond the peak, at its own pace.

    The slips that the sensors show are those before the relaxation of the tyres; the speed reference comes
    `shift` [s] late.
    """
    theta, generator = surface(name), np.random.default_rng(seed)
    static, transfer, radii = np.array(car.load_shares), np.array(car.transfer_shares), np.array(car.radii)
    relaxation_lengths = np.array([wheel.relaxation_length for wheel in car.wheels])
    behind: NDArray[np.float64] = np.zeros(4)
    time, speed, deceleration = 0.0, 40.0, 0.0
    speeds: list[float] = []
    rows: list[tuple[float, float, NDArray[np.float64]]] = []
    while speed > 5.0:
        reach = min(time / 0.4, 1.0) * 0.12
        slips = reach * (1.0 + np.sin(2.0 * np.pi * time * np.array([3.1, 3.7, 4.3, 2.6])))
        behind = slips + np.exp(-STEP * speed / relaxation_lengths) * (behind - slips)
        # The load shares follow the deceleration they make.
        for _ in range(20):
            friction = float((static + transfer * deceleration / 9.81) @ burckhardt.friction(theta, behind))
            drag = car.rolling_resistance * 9.81 + 0.5 * AIR_DENSITY * car.drag_area * speed**2 / car.mass
            deceleration = friction * 9.81 + drag
        rows.append((time, -deceleration, (1.0 - slips) * speed / radii))
        speeds.append(speed)
        time, speed = time + STEP, speed - deceleration * STEP
    times = [row[0] for row in rows]
    return [
        VehicleSample(
            time, float(np.interp(time - shift, times, speeds)), a + generator.normal(0.0, 9.81 * noise), tuple(omega)
        )
        for time, a, omega in rows
    ]


def last_estimate(
    samples: list[VehicleSample], car: Vehicle = CAR, parameters: WholeVehicleParameters = DEFAULT
) -> CurveEstimate:
    vehicle = WholeVehicle(car, parameters)
    estimates = [answer for answer in map(vehicle.update, samples) if isinstance(answer, CurveEstimate)]
    return estimates[-1]


@pytest.mark.parametrize("name", ["high_grip", "wet", "off_road"])
def test_recovers_the_curve_of_the_road(name: str) -> None:
    found = last_estimate(stop(name))
    lambda_max, mu_max = burckhardt.peak(surface(name))
    assert found.valid
    assert abs(found.lambda_max - lambda_max) < 2.0 * found.lambda_max_stddev
    assert found.lambda_max == pytest.approx(lambda_max, rel=0.15)
    assert found.mu_max == pytest.approx(mu_max, rel=0.02)


def test_interval_covers_the_truth_as_often_as_it_says() -> None:
    truth = float(burckhardt.peak(surface("high_grip"))[0])
    found = [last_estimate(stop(seed=seed, noise=0.05)) for seed in range(12)]
    covered = sum(abs(each.lambda_max - truth) < 1.96 * each.lambda_max_stddev for each in found)
    assert covered >= 10


@pytest.mark.parametrize("shift", [-0.01, 0.01])
def test_intervals_allow_for_a_speed_reference_off_by_ten_milliseconds(shift: float) -> None:
    """The squared deviations of four stops add up to less than 9.5 with 95 %."""
    truth = float(burckhardt.peak(surface("high_grip"))[0])
    found = [last_estimate(stop(seed=seed, shift=shift)) for seed in range(4)]
    assert sum(((each.lambda_max - truth) / each.lambda_max_stddev) ** 2 for each in found) < 9.5


def test_doubt_about_timing_widens_the_interval() -> None:
    samples = stop(noise=0.05)[:150]
    sure = last_estimate(samples, parameters=WholeVehicleParameters(timing_stddev=1e-4))
    doubtful = last_estimate(samples, parameters=WholeVehicleParameters(timing_stddev=0.05))
    assert doubtful.lambda_max_stddev > sure.lambda_max_stddev


def test_stays_silent_without_strong_braking() -> None:
    gentle = [
        VehicleSample(k * STEP, 30.0 - 0.02 * k, -2.5, tuple(0.995 * (30.0 - 0.02 * k) / r for r in CAR.radii))
        for k in range(400)
    ]
    vehicle = WholeVehicle(CAR)
    answers = [vehicle.update(sample) for sample in gentle]
    assert any(isinstance(answer, CurveEstimate) for answer in answers)
    assert not any(isinstance(answer, CurveEstimate) and answer.valid for answer in answers)


def test_load_shares_add_up_to_one_whatever_the_deceleration() -> None:
    samples = VehicleSamples(CAR, DEFAULT)
    for sample in stop():
        point = samples.update(sample)
        if isinstance(point, VehiclePoint):
            assert float(np.sum(point.shares)) == pytest.approx(1.0)
            assert point.shares[0] > point.shares[2]


@pytest.mark.parametrize("field", ["relaxation_length", "shift"])
def test_nuisance_derivatives_agree_with_finite_differences(field: str) -> None:
    samples = stop(noise=0.0)[:60]

    def slips(length: float, shift: float) -> NDArray[np.float64]:
        maker = VehicleSamples(with_relaxation(*[length] * 4), DEFAULT)
        points = [maker.update(replace(s, speed=s.speed + shift * s.acceleration)) for s in samples]
        return np.array([point.slips for point in points if isinstance(point, VehiclePoint)])

    # A shift moves the distance behind the relaxation too, which the derivative leaves out: rigid tyres for it.
    length = 1e-3 if field == "shift" else 0.3
    maker = VehicleSamples(with_relaxation(*[length] * 4), DEFAULT)
    points = [point for point in map(maker.update, samples) if isinstance(point, VehiclePoint)]
    h = 1e-4
    if field == "shift":
        expected = (slips(length, h) - slips(length, -h)) / (2 * h)
        found = np.array([point.slips_per_second for point in points])
    else:
        expected = (slips(0.3 * math.exp(h), 0.0) - slips(0.3 * math.exp(-h), 0.0)) / (2 * h)
        found = np.array([point.slips_per_length for point in points])
    assert found == pytest.approx(expected, abs=1e-5)


def test_wheel_speeds_that_are_ahead_move_slips_along_their_rate_and_against_a_speed_that_is_ahead() -> None:
    samples, maker = stop(noise=0.0)[:60], VehicleSamples(with_relaxation(*[1e-3] * 4), DEFAULT)
    point = [maker.update(sample) for sample in samples][-1]
    assert isinstance(point, VehiclePoint)
    before, last = samples[-2:]
    late = 1.0 - np.array(before.wheel_speeds) * CAR.radii / last.speed
    found = point.slip_rates - point.slips_per_second
    assert found == pytest.approx((point.slips - late) / STEP, abs=0.02 * float(np.abs(found).max()))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"speed": math.nan}, Reason.BAD_INPUT),
        ({"acceleration": math.inf}, Reason.BAD_INPUT),
        ({"acceleration": -1e6}, Reason.BAD_INPUT),
        ({"wheel_speeds": (1.0, 2.0)}, Reason.BAD_INPUT),
        ({"wheel_speeds": (math.nan,) * 4}, Reason.BAD_INPUT),
        ({"speed": 0.0}, Reason.LOW_SPEED),
        ({"wheel_speeds": (500.0,) * 4}, Reason.NO_SLIP),
        ({"wheel_speeds": (0.0,) * 4}, Reason.NO_SLIP),
        ({"acceleration": 0.5}, Reason.NO_EXCITATION),
    ],
)
def test_a_bad_sample_is_refused_with_its_reason(change: dict[str, Any], reason: Reason) -> None:
    vehicle, samples = WholeVehicle(CAR), stop()
    for sample in samples[:80]:
        vehicle.update(sample)
    refusal = vehicle.update(replace(samples[80], **change))
    assert isinstance(refusal, Refusal)
    assert refusal.reason is reason
    assert isinstance(vehicle.update(samples[81]), CurveEstimate)


def test_a_gap_and_a_reset_begin_again_and_say_so() -> None:
    samples = stop()
    vehicle = WholeVehicle(CAR)
    for sample in samples[:100]:
        vehicle.update(sample)
    later = [replace(sample, time=sample.time + 0.4) for sample in samples[100:]]
    estimates = [answer for answer in map(vehicle.update, later) if isinstance(answer, CurveEstimate)]
    assert estimates[0].restarted
    assert estimates[0].restart_cause is RestartCause.GAP
    vehicle.reset()
    estimates = [answer for answer in map(vehicle.update, samples) if isinstance(answer, CurveEstimate)]
    assert estimates[0].restart_cause is RestartCause.REQUEST
    assert estimates[-1].lambda_max == pytest.approx(last_estimate(samples).lambda_max)


@pytest.mark.parametrize("values", [{"timing_stddev": 0.0}, {"minimum_speed": 0.0}])
def test_parameters_that_admit_nothing_are_refused_by_name(values: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=next(iter(values))):
        from_mapping(WholeVehicleParameters, values)


def test_every_tyre_answers_over_its_own_relaxation_length() -> None:
    car = with_relaxation(0.05, 0.3, 0.3, 1.5)
    samples = stop(noise=0.0, car=car)
    truth = burckhardt.peak(surface("high_grip"))
    found = last_estimate(samples, car)
    assert found.lambda_max == pytest.approx(float(truth[0]), rel=0.05)
    points = [VehicleSamples(car, DEFAULT), VehicleSamples(with_relaxation(0.3, 0.3, 0.3, 0.3), DEFAULT)]
    answers = [[maker.update(sample) for sample in samples[:40]][-1] for maker in points]
    own, common = (answer.slips for answer in answers if isinstance(answer, VehiclePoint))
    assert list(own == common) == [False, True, True, False]


def test_doubt_about_the_relaxation_length_is_that_of_the_vehicle_file() -> None:
    def doubtful(stddev: float) -> Vehicle:
        deviations = {"relaxation_length": Deviation(stddev, SharedBy.ALL)}
        return replace(CAR, wheels=tuple(replace(wheel, deviations=deviations) for wheel in CAR.wheels))

    unstated = replace(CAR, wheels=tuple(replace(wheel, deviations={}) for wheel in CAR.wheels))
    assert relaxation_spread(doubtful(0.06)) == pytest.approx(0.2)
    assert relaxation_spread(unstated) == 0.5
    samples = stop(noise=0.05)[:150]
    stddevs = [last_estimate(samples, car).lambda_max_stddev for car in (doubtful(0.003), doubtful(0.3))]
    assert stddevs[0] < stddevs[1]


def test_drag_and_rolling_resistance_are_those_of_the_car() -> None:
    def friction(**changes: float) -> float:
        maker = VehicleSamples(replace(CAR, **changes), DEFAULT)  # type: ignore[arg-type]
        point = maker.update(VehicleSample(0.0, 40.0, -9.81, tuple(38.0 / r for r in CAR.radii)))
        assert isinstance(point, VehiclePoint)
        return point.friction

    free = friction(drag_area=0.0, rolling_resistance=0.0)
    assert free == pytest.approx(1.0)
    assert free - friction(drag_area=0.0, rolling_resistance=0.02) == pytest.approx(0.02)
    drag = 0.5 * 1.2 * 0.8 * 40.0**2 / (CAR.mass * 9.81)
    assert free - friction(drag_area=0.8, rolling_resistance=0.0) == pytest.approx(drag)


ANY = st.one_of(st.floats(), st.floats(-20.0, 60.0))
HOSTILE = st.builds(VehicleSample, ANY, ANY, ANY, st.lists(ANY, min_size=3, max_size=5).map(tuple))


@settings(max_examples=20)
@given(hostile=st.lists(st.tuples(st.integers(0, 70), HOSTILE), max_size=20))
def test_hostile_streams_are_answered_and_survived(hostile: list[tuple[int, VehicleSample]]) -> None:
    stream = list(STREAM)
    for place, sample in hostile:
        stream.insert(place, sample)
    vehicle = WholeVehicle(CAR)
    for sample in stream:
        answer = vehicle.update(sample)
        if isinstance(answer, CurveEstimate):
            assert math.isnan(answer.lambda_max) or 0.0 < answer.lambda_max < 1.0
            assert np.all(np.isfinite(answer.theta))
        else:
            assert answer.text


STREAM = stop()[:70]
