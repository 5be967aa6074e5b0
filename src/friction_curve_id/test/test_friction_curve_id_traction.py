"""mu_max from wheels that spin under the engine, by the estimator of a car on a plant that shares no code with it."""

from dataclasses import replace
from math import inf, isnan

import numpy as np
import pytest

from corner_sim.car.car import Car
from corner_sim.car.driving import Cycling, EngineCycle, PressureProfile
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.interface import CurveEstimate
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
NO_BRAKE = PressureProfile((0.0,), (0.0,))
FAST_CUT = Cycling(ramp=1.0, reapply=0.4, release=0.06, upper=3.0)
"""Wheels spin to three times the slip of the peak, as they do before a driver or a control notices."""


def spin(road: str, most: float = inf, right: str = "", family: str = "pacejka", seconds: float = 4.0) -> Recording:
    """Start with a throttle that lets the rear wheels spin, at most a share of what brings them to their peak."""
    left, other = TYRES[family][road], TYRES[family][right or road]
    parameters = replace(random_car(70_000, road, family).parameters, tyres=(left, other, left, other))
    engine = EngineCycle(parameters, FAST_CUT, most)
    car = Car(parameters, 6.0, 70_000)
    return record(parameters, NO_BRAKE, 70_000, speed=6.0, duration=seconds, surroundings=engine, car=car)


def told(run: Recording, vehicle: Vehicle = CAR, pressure: float = 0.0) -> list[tuple[float, int, CurveEstimate]]:
    """Return the estimates with time and wheel, those that are none left out."""
    estimator = CarEstimator(vehicle)
    found = []
    for time, speeds, acceleration in zip(run.time.tolist(), run.wheel_speed, run.acceleration.tolist(), strict=True):
        answers = estimator.update(CarSample(time, speeds, [pressure] * 4, acceleration))
        found += [(time, k, each) for k, each in enumerate(answers) if isinstance(each, CurveEstimate)]
    return found


@pytest.mark.parametrize("road", ["dry", "snow"])
def test_wheels_that_spin_tell_mu_max_and_not_the_slip_of_the_peak(road: str) -> None:
    run = spin(road, seconds=8.0)
    known = [(k, each) for _, k, each in told(run) if each.mu_max_known]
    assert known
    assert {k for k, _ in known} <= {2, 3}
    for _, each in known:
        assert abs(each.mu_max - TYRES["pacejka"][road].peak[1]) < 1.96 * each.mu_max_stddev
        assert each.mu_max_stddev < 0.25 * each.mu_max
        assert isnan(each.lambda_max)
        assert not each.valid
        assert each.reason is Reason.NO_EXCITATION


@pytest.mark.parametrize("road", ["dry", "snow"])
@pytest.mark.parametrize("most", [0.5, 0.85])
def test_before_the_peak_nothing_is_known(road: str, most: float) -> None:
    assert not [each for _, _, each in told(spin(road, most)) if each.mu_max_known or not isnan(each.mu_max)]


def test_what_is_told_before_is_told_as_waiting_for_the_peak() -> None:
    early = [each for _, _, each in told(spin("dry")) if not each.mu_max_known]
    assert {each.reason for each in early} <= {Reason.PEAK_NOT_PASSED, Reason.UNCERTAIN}
    assert early[0].reason is Reason.PEAK_NOT_PASSED


def test_on_a_split_road_no_wheel_has_the_friction_of_the_other() -> None:
    run = spin("dry", right="snow")
    for time, wheel, each in told(run):
        truth = run.mu_max[int(np.searchsorted(run.time, time)), wheel]
        assert not each.mu_max_known or abs(each.mu_max - truth) < 1.96 * each.mu_max_stddev


def test_where_no_axle_runs_free_or_a_brake_acts_nothing_is_told_of_traction() -> None:
    run = spin("snow", seconds=8.0)
    assert told(run)
    driven = tuple(replace(wheel, driven=True) for wheel in CAR.wheels)
    assert told(run, replace(CAR, wheels=driven)) == []
    assert told(run, pressure=20e5) == []  # from the first sample on: the speed before this braking is unknown


def test_once_the_wheels_grip_the_number_is_not_told_any_more() -> None:
    run = spin("snow")
    gripped = replace(
        run, time=run.time + run.time[-1] + 0.01, wheel_speed=np.repeat(run.wheel_speed[:1], len(run.time), 0)
    )
    estimator = CarEstimator(CAR)
    for each in (run, gripped):
        for time, speeds in zip(each.time.tolist(), each.wheel_speed, strict=True):
            answers = estimator.update(CarSample(time, speeds, [0.0] * 4, 0.0 if each is gripped else 1.0))
    assert not [answer for answer in answers if isinstance(answer, CurveEstimate)]
