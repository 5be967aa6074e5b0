"""Stops in curves: the car enters one, and is braked to the limit there; each wheel has its own path and slip."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from benchmarks.runner import Row, at_least, at_most, not_judged
from benchmarks.slip.car_drives import Case, differing
from corner_sim.car.car import STEP
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.measured_car import MeasuredCar
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimator import EstimatorParameters, SlipEstimator

Array = NDArray[np.float64]

SPEED: Final = 25.0
ENTERED, BEND, BRAKED = 5.0, 1.0, 7.0
"""Begin of the curve, time in which it grows, begin of braking [s]."""
LONGEST: Final = 14.0
SLOWEST: Final = 3.0
SPUN: Final = 0.35
"""Lateral over forward speed at which a car has spun and a stop ends [-]."""
YAW_OFFSET, YAW_NOISE = 0.01, 0.003
"""[rad/s]"""
PRESSURE_AGE: Final = 0.02
"""Time after which the node uses a brake pressure [s]."""
CURVES: Final = (("dry", 0.3), ("dry", 0.6), ("dry", 0.8), ("wet", 0.3), ("wet", 0.5), ("snow", 0.12))
"""Road and lateral acceleration at the start [g]."""
MOST_ON_DRY, LEAST_COVERED = 0.008, 90.0


@dataclass(frozen=True)
class Slips:
    """Errors of the valid slips while braked and moving, and their stated deviations [-], shape (N,)."""

    error: Array
    deviation: Array
    valid: float
    """Share of valid slips [%]."""


def curve_rows(vehicle: Vehicle, parameters: EstimatorParameters, seeds: Sequence[int]) -> list[Row]:
    """Return the rows of all curves, with a yaw rate and without; each with one car for each seed."""
    rows: list[Row] = []
    for (road, lateral), yaw in track([(each, yaw) for each in CURVES for yaw in (True, False)], description="curves"):
        runs = [_stop(vehicle, parameters, road, lateral, yaw, seed) for seed in seeds]
        error = np.concatenate([run.error for run in runs])
        z = error / np.concatenate([run.deviation for run in runs])
        rms, covered = float(np.sqrt(np.mean(error**2))), 100.0 * float(np.mean(np.abs(z) < 1.96))
        name = f"{road}, braked to the limit in a curve of {lateral} g{'' if yaw else ', no yaw rate'}"
        start = {"case": name, "runs": len(runs)}
        limited = at_most(rms, MOST_ON_DRY) if road == "dry" and yaw else not_judged(rms)
        rows += [
            {**start, "quantity": "slip RMS [-]", **limited},
            {**start, "quantity": "coverage of the slip [%]", **at_least(covered, LEAST_COVERED)},
            {**start, "quantity": "valid [%]", **not_judged(float(np.mean([run.valid for run in runs])))},
        ]
    return rows


def _stop(vehicle: Vehicle, parameters: EstimatorParameters, road: str, lateral: float, yaw: bool, seed: int) -> Slips:
    given = differing(Case(road=road), vehicle, seed)
    car = CorneringCar(given, SPEED, seed)
    measured = MeasuredCar(given, SPEED, seed, car)
    pedal = SlipCycle(given, Cycling(start=BRAKED))
    estimator, rng = SlipEstimator(vehicle, parameters), np.random.default_rng([seed, 21])
    offset = YAW_OFFSET * float(rng.normal())
    gains = [wheel.brake_gain for wheel in vehicle.wheels]
    pressures: list[list[float]] = []
    found: list[tuple[float, float]] = []
    judged = 0
    while measured.time < LONGEST and car.speed > SLOWEST and abs(car.lateral_speed) < SPUN * car.speed:
        if measured.time % (measured.steps_per_sample * STEP) < 0.5 * STEP:
            reading = measured.measure()
            pressures.append([gain * each for gain, each in zip(gains, reading.brake_pressure, strict=True)])
            age = round(PRESSURE_AGE / (measured.steps_per_sample * STEP))
            turned = car.yaw_rate + offset + YAW_NOISE * float(rng.normal())
            answers = estimator.update(
                round((reading.time + 1.0) * 1e9),
                reading.wheel_speed,
                reading.acceleration,
                torques=pressures[-1 - age] if len(pressures) > age else [float("nan")] * 4,
                yaw_rate=turned if yaw else None,
            )
            if measured.time > BRAKED:
                judged += 4
                found += [
                    (answer.slip - true, answer.slip_variance)
                    for answer, true in zip(answers, car.slip, strict=True)
                    if not answer.reason
                ]
        ramp = min(max((measured.time - ENTERED) / BEND, 0.0), 1.0)
        curvature = lateral * GRAVITY * ramp / max(car.speed, 5.0) ** 2
        measured.step(pedal.pressure(measured.time, STEP, car), 0.0, 0.0, curvature)
    table = np.reshape(found, (-1, 2))
    return Slips(table[:, 0], np.sqrt(table[:, 1]), 100.0 * len(found) / judged)
