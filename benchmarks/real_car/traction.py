"""Starts with wheels that spin under the engine: mu_max of random cars, straight, in curves, on two roads.

Rear-driven cars, whose front wheels show the speed. What never passes the peak may have no number; on two roads what is
told of a wheel has to be true of its own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.cycled_stops import FAMILIES, VEHICLE
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.car import Car
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import Cycling, EngineCycle, PressureProfile, Surroundings
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.interface import CurveEstimate
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

COVERAGE: Final = 90.0
"""Least share of the numbers whose 95 % intervals hold the truth [%]."""
ERROR: Final = 10.0
"""Largest median of the errors [%]: on snow the bias of the accelerometer alone is one of 9 %."""
GRACE: Final = 0.2
"""Time on another road from which on numbers are judged again [s]."""
_SPEED, _DURATION, _CHANGE = 6.0, 5.0, 2.5
"""[m/s] at the begin; [s] of a drive, and when the road changes."""
_INTERVAL: Final = 1.96
_NO_BRAKE: Final = PressureProfile((0.0,), (0.0,))


@dataclass(frozen=True)
class Start:
    """A kind of start."""

    name: str
    road: str
    family: str = "burckhardt"
    lateral: float = 0.0
    """Lateral acceleration in the middle of the drive, about [g]."""
    most: float = inf
    """Largest torque over that at the peak [-]: below 1 no wheel passes it."""
    right: str = ""
    """Road of the right wheels, where it is another one."""
    then: str = ""
    """Road from the middle of the drive on, where it is another one."""


def _starts() -> Iterator[Start]:
    for family, roads in FAMILIES.items():
        for road in roads:
            yield Start(f"{family} {road}", road, family)
    for road, lateral in (("dry", 0.3), ("wet", 0.2), ("snow", 0.03)):
        yield Start(f"curve {road} {lateral} g", road, lateral=lateral)
    for most in (0.5, 0.85):
        for road in ("dry", "snow"):
            yield Start(f"held at {most} of the peak, {road}", road, most=most)
    for road, right in (("dry", "snow"), ("wet", "snow"), ("dry", "wet")):
        yield Start(f"split {road} | {right}", road, right=right)
    for road, then in (("snow", "dry"), ("dry", "snow"), ("wet", "dry")):
        yield Start(f"{road} to {then}", road, then=then)


STARTS: Final = {start.name: start for start in _starts()}


@dataclass(frozen=True)
class Told:
    """What was told in one drive."""

    after: float
    """From the first passing of the peak to the first number [s]; infinite where there is none, NaN without one."""
    errors: Array
    """Relative errors of mu_max, shape (numbers,)."""
    deviations: Array
    """The same over their standard deviations."""


def make_start(job: tuple[str, int]) -> Told:
    """Drive a kind of start, by name, with a seed, and compare what was told with the truth."""
    name, seed = job
    start = STARTS[name]
    rng = np.random.default_rng([seed, 7])
    drawn = random_car(seed, start.road, "burckhardt").parameters
    tyres = [FAMILIES[start.family][road] for road in (start.road, start.right or start.road)]
    parameters = replace(drawn, tyres=(tyres[0], tyres[1], tyres[0], tyres[1]))
    cycling = Cycling(
        ramp=float(np.exp(rng.uniform(log(0.3), log(2.0)))),
        reapply=0.4,
        release=0.06,
        upper=float(rng.uniform(1.5, 4.0)),
    )
    speed = 3.0 * _SPEED if start.lateral else _SPEED
    engine = EngineCycle(parameters, cycling, start.most, start.lateral * GRAVITY / speed**2)
    car: Car = (CorneringCar if start.lateral else Car)(parameters, speed, seed)

    def around(time: float, car: Car) -> Surroundings:
        if start.then and time >= _CHANGE:
            car.tyres = [FAMILIES[start.family][start.then]] * 4
        return engine(time, car)

    run = record(parameters, _NO_BRAKE, seed, speed=speed, duration=_DURATION, surroundings=around, car=car)
    truth = run.mu_max.copy()
    changed = run.time >= _CHANGE if start.then else np.zeros(len(run.time), dtype=bool)
    if start.then:
        truth[changed] *= FAMILIES[start.family][start.then].peak[1] / tyres[0].peak[1]
    judged = ~changed | (run.time >= _CHANGE + GRACE)
    estimator = CarEstimator(load_vehicle(VEHICLE))
    told = []
    for k in range(len(run.time)):
        sample = CarSample(float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]))
        for wheel, answer in enumerate(estimator.update(sample)):
            if isinstance(answer, CurveEstimate) and answer.mu_max_known and judged[k]:
                told.append((run.time[k], answer.mu_max / truth[k, wheel] - 1.0, answer.mu_max_stddev / answer.mu_max))
    table = np.array(told).reshape(-1, 3)
    passed = (-run.tyre_slip[:, 2:] > run.lambda_max[2:]).any(axis=1)
    first = float(run.time[passed.argmax()]) if passed.any() else np.nan
    after = float(table[0, 0]) - first if len(table) else inf if passed.any() else np.nan
    return Told(after, table[:, 1], table[:, 1] / table[:, 2])


def start_rows(name: str, drives: Sequence[Told]) -> list[Row]:
    """Rows of a kind of start."""
    start = STARTS[name]
    errors = np.concatenate([drive.errors for drive in drives])
    deviations = np.concatenate([drive.deviations for drive in drives])
    head: Row = {"case": f"traction, {name}", "road": start.road, "stops": len(drives)}
    with_number = 100.0 * float(np.mean([len(drive.errors) > 0 for drive in drives]))
    silent = start.most < 1.0
    told = at_most(with_number, 0.0) if silent else not_judged(with_number)
    rows: list[Row] = [head | {"quantity": "starts with a mu_max [%]"} | told]
    if silent or not len(errors):
        return rows
    inside = 100.0 * float(np.mean(np.abs(deviations) <= _INTERVAL))
    rows.append(head | {"quantity": "coverage of mu_max [%]"} | at_least(inside, COVERAGE))
    one_road = not (start.right or start.then)
    median = 100.0 * float(np.median(np.abs(errors)))
    judged = at_most(median, ERROR) if one_road else not_judged(median)
    rows.append(head | {"quantity": "median error of mu_max [%]"} | judged)
    after = float(np.median([drive.after for drive in drives if np.isfinite(drive.after)]))
    rows.append(head | {"quantity": "mu_max after the passing, median [s]"} | not_judged(after))
    return rows
