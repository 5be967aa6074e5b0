"""Ordinary drives with an accelerometer that becomes late, frozen, biased, scaled or wrongly signed in mid-drive.

Beside them one that falls silent: a faulty one cannot do better.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from benchmarks.runner import Row, at_most, not_judged
from benchmarks.slip.car_drives import ordinary_drive
from benchmarks.slip.recorded_drive import INTERVAL, LEAST_SPEED, estimates
from corner_sim.car.recording import Recording
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimator import EstimatorParameters, SlipEstimator

Array = NDArray[np.float64]

FROM: Final = 20.0
"""Begin of the fault [s]: the car has driven and braked by then."""
LONGEST: Final = 2.0
"""Time for which a valid speed may be beyond its 95 % interval [s]."""


def _late(delay: float, reading: Array, dt: float) -> Array:
    return np.concatenate((np.full(round(delay / dt), reading[0]), reading))[: len(reading)]


FAULTS: Final[Mapping[str, Callable[[Array, float], Array]]] = {
    "none": lambda reading, dt: reading,
    "silent": lambda reading, dt: np.full_like(reading, np.nan),
    **{f"{delay} s late": partial(_late, delay) for delay in (0.1, 0.2, 0.5, 1.0, 1.5)},
    "frozen": lambda reading, dt: np.full_like(reading, reading[round(FROM / dt)]),
    "wrong sign": lambda reading, dt: -reading,
    "+0.35 m/s^2": lambda reading, dt: reading + 0.35,
    "+5 %": lambda reading, dt: 1.05 * reading,
}
"""Readings [m/s^2] as functions of the true ones and their period [s]."""


def fault_rows(vehicle: Vehicle, parameters: EstimatorParameters, seeds: Sequence[int]) -> list[Row]:
    """Return the rows of all faults, each with one drive for each seed."""
    rows: list[Row] = []
    for name, fault in track(FAULTS.items(), description="faults"):
        runs = np.array([_follow(ordinary_drive(seed), fault, vehicle, parameters) for seed in seeds])
        start = {"case": f"accelerometer: {name}", "runs": len(runs)}
        longest, rms = float(runs[:, 0].max()), float(np.sqrt(np.mean(runs[:, 1] ** 2)))
        named, valid = (100.0 * float(runs[:, column].mean()) for column in (2, 3))
        rows += [
            {**start, "quantity": "longest time beyond the interval [s]", **at_most(longest, LONGEST)},
            {**start, "quantity": "speed RMS [m/s]", **not_judged(rms)},
            {**start, "quantity": "drives in which it is named [%]", **not_judged(named)},
            {**start, "quantity": "valid [%]", **not_judged(valid)},
        ]
    return rows


def _follow(
    run: Recording, fault: Callable[[Array, float], Array], vehicle: Vehicle, parameters: EstimatorParameters
) -> tuple[float, float, bool, float]:
    """Return longest time beyond the interval [s], speed RMS [m/s], whether it is named, and share of valid slips."""
    dt = float(run.time[1] - run.time[0])
    after = run.time >= FROM
    run = replace(run, acceleration=np.where(after, fault(run.acceleration, dt), run.acceleration))
    estimator = SlipEstimator(vehicle, parameters)
    errors, lasts, longest, named = [], 0.0, 0.0, False
    for (answer, *_), time, speed in zip(estimates(estimator, run, vehicle), run.time, run.speed, strict=True):
        named = named or (time >= FROM and bool(estimator.accelerometer_text))
        if answer.reason or time < FROM or speed < LEAST_SPEED:
            lasts = 0.0
            continue
        error = answer.vehicle_speed - speed
        errors.append(error)
        lasts = lasts + dt if abs(error) > INTERVAL * answer.vehicle_speed_variance**0.5 else 0.0
        longest = max(longest, lasts)
    judged = max(int((after & (run.speed > LEAST_SPEED)).sum()), 1)
    return longest, float(np.sqrt(np.mean(np.square(errors)))), named, len(errors) / judged
