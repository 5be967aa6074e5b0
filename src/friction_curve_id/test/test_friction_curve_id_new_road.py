"""A road that changes within a braking: the curve begins anew, what is known of the car stays."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from corner_sim.car.car import Car
from corner_sim.car.driving import SlipCycle, Surroundings
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.memory import forgotten, loosened
from friction_curve_id.car.new_road import NewRoad, axle_on_new_road
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
CAR = load_vehicle("compact_car")
CONSTANTS = CarConstants(CAR, (0, 1, 2, 3))
FRONT = CONSTANTS.front[:, 0] == 1.0
TIME: Array = np.array([0.005 * k for k in range(40)])
FITTED: Array = np.full((4, TIME.size), 1.1)
TOLD = np.ones(FITTED.shape, dtype=bool)
WAY = 18.0


def found(used: Array, told: NDArray[np.bool_] = TOLD) -> NewRoad | None:
    return axle_on_new_road(CONSTANTS, TIME, used, FITTED, told)


def from_node(first: int, share: Array | float) -> Array:
    """Friction used: that of the curve, and shares of it from a node on, shape (W,) or one for the front wheels."""
    used = FITTED.copy()
    shares = np.where(FRONT, share, 1.0) if np.ndim(share) == 0 else np.asarray(share)
    used[:, first:] *= shares[:, np.newaxis]
    return used


@pytest.mark.parametrize("share", [0.15, 0.5])
def test_an_axle_that_uses_much_less_is_on_another_road_since_then(share: float) -> None:
    road = found(from_node(34, share))
    assert road is not None
    assert road.wheels.tolist() == FRONT.tolist()
    assert (road.known_until, road.since) == (TIME[33], TIME[34])


def test_the_old_road_is_known_until_a_wheel_last_told_it() -> None:
    told = TOLD.copy()
    told[:, 25:34] = False
    road = found(from_node(30, 0.15), told)
    assert road is not None
    assert (road.known_until, road.since) == (TIME[24], TIME[34])


def test_what_the_wheels_tell_before_they_stand_is_enough() -> None:
    told = TOLD.copy()
    told[:, 37:] = False
    road = found(from_node(34, 0.15), told)
    assert road is not None and road.since == TIME[34]
    told[:, 36:] = False
    told[:, :34] = False
    assert found(from_node(34, 0.15), told) is None, "two samples may be a bump"


def test_teeth_that_come_slowly_hide_no_road() -> None:
    """A wheel that hardly turns gains and loses speed by whole teeth."""
    used = from_node(34, 0.15)
    used[:, 36], used[:, 37] = FITTED[:, 36], -0.7 * FITTED[:, 37]
    road = found(used)
    assert road is not None and road.since == TIME[34]


@pytest.mark.parametrize(
    "share",
    [
        0.7,
        1.45,
        6.0,
        np.where(FRONT & (CONSTANTS.left[:, 0] > 0.0), 0.15, 1.0),
        np.where(CONSTANTS.left[:, 0] > 0.0, 0.15, 1.0),
        np.where(CONSTANTS.left[:, 0] > 0.0, 0.3, 3.0),
    ],
)
def test_an_error_of_the_car_a_sensor_that_fails_or_a_split_road_is_none(share: Array | float) -> None:
    assert found(from_node(30, share)) is None


def test_a_wheel_alone_is_the_axle_of_a_single_corner() -> None:
    corner = CarConstants(load_vehicle("chapter_corner"), (0,))
    road = axle_on_new_road(corner, TIME, from_node(34, 0.15)[:1], FITTED[:1], TOLD[:1])
    assert road is not None and road.since == TIME[34]


def test_a_bump_is_none() -> None:
    assert found(from_node(38, 0.4)) is None


def test_the_forgotten_is_as_if_it_had_never_been_known() -> None:
    random = np.random.default_rng(3)
    root = random.normal(size=(4, 4))
    information, gradient = root @ root.T + np.eye(4), random.normal(size=4)
    left, slope = forgotten(information, gradient, 1)
    others = [0, 2, 3]
    covariance = np.linalg.inv(information)
    assert np.linalg.inv(left[np.ix_(others, others)]) == pytest.approx(covariance[np.ix_(others, others)])
    at = -np.linalg.solve(information, gradient)
    assert -np.linalg.solve(left[np.ix_(others, others)], slope[others]) == pytest.approx(at[others])
    assert np.abs([left[1], left[:, 1]]).max() < 1e-12
    assert abs(slope[1]) < 1e-12


def test_a_drift_adds_its_own_variance() -> None:
    random = np.random.default_rng(4)
    root, step = random.normal(size=(4, 4)), random.normal(size=4)
    information, gradient = root @ root.T + np.eye(4), random.normal(size=4)
    left, slope = loosened(information, gradient, step, 0.7)
    before, after = np.linalg.inv(information), np.linalg.inv(left)
    assert after == pytest.approx(before + 0.7 * np.outer(step, step))
    assert after @ slope == pytest.approx(before @ gradient)


class DryThenSnow:
    """Snow a little after the begin of braking, under each axle where it comes to it."""

    def __init__(self, begin: float, wheelbase: float) -> None:
        self.begin, self.behind = begin, np.array([0.0, 0.0, wheelbase, wheelbase])
        self.from_here: float | None = None
        self.time = np.full(4, np.inf)

    def __call__(self, time: float, car: Car) -> Surroundings:
        if self.from_here is None and time >= self.begin:
            self.from_here = car.distance
        if self.from_here is not None:
            for wheel in np.flatnonzero(car.distance - self.from_here - self.behind > WAY):
                car.tyres[wheel] = TYRES["burckhardt"]["snow"]
                self.time[wheel] = min(self.time[wheel], time)
        return Surroundings()


@cache
def stop(seed: int) -> tuple[Recording, DryThenSnow]:
    car = random_car(seed, "dry", "burckhardt")
    road = DryThenSnow(car.cycling.start, car.parameters.wheelbase)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), seed, duration=3.2, surroundings=road)
    return run, road


def answers(run: Recording) -> list[CurveEstimate | Refusal]:
    estimator = CarEstimator(CAR)
    return [
        estimator.update(CarSample(time, run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])))[0]
        for k, time in enumerate(run.time.tolist())
    ]


@pytest.mark.parametrize("seed", [98_004, 98_006])
def test_the_curve_of_another_road_is_found_within_the_braking(seed: int) -> None:
    run, road = stop(seed)
    given = answers(run)
    estimates = [(time, each) for time, each in zip(run.time, given, strict=True) if isinstance(each, CurveEstimate)]
    anew = [time for time, each in estimates if each.restart_cause is RestartCause.SURFACE]
    assert len(anew) == 1
    assert road.time[0] < anew[0] < road.time[0] + 0.15
    valid = [(time, each) for time, each in estimates if each.valid and time > anew[0]]
    assert valid
    mu_max, lambda_max = TYRES["burckhardt"]["snow"].peak[1], TYRES["burckhardt"]["snow"].peak[0]
    right = [
        abs(each.mu_max - mu_max) < 1.96 * each.mu_max_stddev
        and abs(each.lambda_max - lambda_max) < 1.96 * each.lambda_max_stddev
        for _, each in valid
    ]
    assert np.mean(right) > 0.9


@pytest.mark.parametrize("roads", [("snow", "wet"), ("wet", "dry")])
def test_the_curve_of_a_road_that_grips_better_is_found_within_the_braking(roads: tuple[str, str]) -> None:
    """Before, nothing was valid until the next braking."""
    old, new = (TYRES["burckhardt"][road] for road in roads)
    right = []
    for seed in (98_004, 98_006):
        car = random_car(seed, roads[0], "burckhardt")
        parameters, begin = replace(car.parameters, slope=0.0), car.cycling.start + 1.5

        def around(time: float, moved: Car, begin: float = begin) -> Surroundings:
            moved.tyres = [new if time > begin + 0.1 * (wheel > 1) else old for wheel in range(4)]
            return Surroundings()

        run = record(parameters, SlipCycle(parameters, car.cycling), seed, duration=4.0, surroundings=around)
        estimates = [
            (time, each) for time, each in zip(run.time, answers(run), strict=True) if isinstance(each, CurveEstimate)
        ]
        anew = [time for time, each in estimates if each.restart_cause is RestartCause.SURFACE]
        assert anew and begin < anew[0] < begin + 0.4
        right += [
            abs(each.mu_max - new.peak[1]) < 1.96 * each.mu_max_stddev
            for time, each in estimates
            if each.valid and time > anew[0]
        ]
    assert len(right) > 50
    assert np.mean(right) > 0.9


def test_brakes_that_an_anti_lock_system_has_opened_are_no_end_of_the_braking() -> None:
    run, road = stop(98_006)
    until = int(np.searchsorted(run.time, road.time[0]))
    for rolling, ends in ((0.5, False), (1.0, True)):
        estimator = CarEstimator(CAR)
        for k in range(until):
            sample = CarSample(
                float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])
            )
            estimator.update(sample)
        free = rolling * run.speed[until] / np.array(CAR.radii)
        open_for = int(0.3 / (run.time[1] - run.time[0]))
        for k in range(until, until + open_for):
            (last, *_) = estimator.update(CarSample(float(run.time[k]), free, np.zeros(4), 0.0))
        assert (last.reason is Reason.NO_EXCITATION) == ends
