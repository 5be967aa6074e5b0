"""Estimates over a recording, sample by sample."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.real_car.methods import METHODS
from benchmarks.stated import STATED, stated
from corner_sim.car.recording import Recording
from friction_curve_id.interface import Refusal
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
VEHICLE = "compact_car"
"""Vehicle file of the estimators: nominal values and deviations, of no car of the plant."""


@dataclass(frozen=True)
class Answers:
    """Answers after each of n samples, STATED in order, arrays of shape (n, 4); NaN where there was none."""

    lambda_max: Array
    lambda_max_stddev: Array
    mu_max: Array
    mu_max_stddev: Array
    probability_beyond_peak: Array
    valid: Array
    """Whether it was valid, 0 or 1."""
    restarted: Array


def follow(method: str, run: Recording, samples: int) -> Answers:
    """Feed the first `samples` samples of a recording to an estimator by name."""
    estimator = METHODS[method](load_vehicle(VEHICLE))
    found = np.full((samples, 4, len(STATED)), np.nan)
    found[:, :, -2:] = 0.0
    for k in range(samples):
        answers = estimator.update(
            float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])
        )
        for wheel, answer in enumerate(answers):
            if not isinstance(answer, Refusal):
                found[k, wheel] = stated(answer)
    return Answers(*np.moveaxis(found, 2, 0))
