"""Stops in curves: the car enters one, and is braked to the limit there; each wheel has its own path and slip."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from rich.progress import track

from benchmarks.runner import Row, at_least, at_most, not_judged
from benchmarks.slip.car_drives import Case, differing
from benchmarks.slip.recorded_drive import Array, covered, estimates
from corner_sim.car.car import Car
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import Cycling, SlipCycle, Surroundings
from corner_sim.car.recording import Recording, record
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimator import EstimatorParameters, SlipEstimator

SPEED: Final = 25.0
ENTERED, BEND, BRAKED = 5.0, 1.0, 7.0
"""Begin of the curve, time in which it grows, begin of braking [s]."""
LONGEST: Final = 14.0
YAW_OFFSET, YAW_NOISE = 0.01, 0.003
"""[rad/s]"""
CURVES: Final = (("dry", 0.3), ("dry", 0.6), ("dry", 0.8), ("wet", 0.3), ("wet", 0.5), ("snow", 0.12))
"""Road and lateral acceleration at the start [g]."""
MOST_ON_DRY, LEAST_COVERED = 0.008, 90.0


def curve_rows(vehicle: Vehicle, parameters: EstimatorParameters, seeds: Sequence[int]) -> list[Row]:
    """Return the rows of all curves, with a yaw rate and without; each with one car for each seed."""
    rows: list[Row] = []
    for road, lateral in track(CURVES, description="curves"):
        stops = [(seed, _stop(vehicle, road, lateral, seed)) for seed in seeds]
        for yaw in (True, False):
            slips = [_slips(stop, vehicle, parameters, _measured(stop, seed) if yaw else None) for seed, stop in stops]
            error, deviation = np.concatenate(slips)[:, :2].T
            known = np.isfinite(error)
            rms = float(np.sqrt(np.mean(error[known] ** 2)))
            name = f"{road}, braked to the limit in a curve of {lateral} g{'' if yaw else ', no yaw rate'}"
            start = {"case": name, "runs": len(seeds)}
            limited = at_most(rms, MOST_ON_DRY) if road == "dry" and yaw else not_judged(rms)
            inside = covered(error[known] / deviation[known])
            rows += [
                {**start, "quantity": "slip RMS [-]", **limited},
                {**start, "quantity": "coverage of the slip [%]", **at_least(inside, LEAST_COVERED)},
                {**start, "quantity": "valid [%]", **not_judged(100.0 * float(np.mean(known)))},
            ]
    return rows


def _stop(vehicle: Vehicle, road: str, lateral: float, seed: int) -> Recording:
    def around(time: float, car: Car) -> Surroundings:
        ramp = min(max((time - ENTERED) / BEND, 0.0), 1.0)
        return Surroundings(curvature=lateral * GRAVITY * ramp / max(car.speed, 5.0) ** 2)

    given = differing(Case(road=road), vehicle, seed)
    pedal, car = SlipCycle(given, Cycling(start=BRAKED)), CorneringCar(given, SPEED, seed)
    return record(given, pedal, seed, speed=SPEED, duration=LONGEST, surroundings=around, car=car)


def _measured(stop: Recording, seed: int) -> Array:
    """Return the yaw rate as a gyroscope reads it [rad/s], (N,)."""
    rng = np.random.default_rng([seed, 21])
    return np.asarray(stop.yaw_rate + YAW_OFFSET * rng.normal() + YAW_NOISE * rng.normal(size=stop.yaw_rate.size))


def _slips(stop: Recording, vehicle: Vehicle, parameters: EstimatorParameters, yaw_rate: Array | None) -> Array:
    """Return errors and deviations of the slips while braked, shape (M, 2); NaN where one is not valid."""
    estimator = SlipEstimator(vehicle, parameters)
    found = [
        (answer.slip - true, answer.slip_variance**0.5)
        for answers, time, slip in zip(estimates(estimator, stop, vehicle, yaw_rate), stop.time, stop.slip, strict=True)
        for answer, true in zip(answers, slip, strict=True)
        if time > BRAKED
    ]
    return np.array(found)
