"""Wheels in the drives of a calibration, and the excitation that these drives lack, known before anything is fitted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.patch_tracker import Passage
from vehicle_models.vehicle import Wheel

Array = NDArray[np.float64]

ACCELERATING, BRAKING = 1.0, -2.0
"""Accelerations beyond which a drive shows the cross-talk of the load, and the braking part of the map [m/s^2]."""
_FEWEST = 5
"""Revolutions that are needed beyond each."""


@dataclass(frozen=True)
class WheelRun:
    """Passages of one wheel in one drive."""

    wheel: Wheel
    passages: list[Passage]
    time: Array
    """Times of the car's acceleration, on the time scale of the passages [s], increasing, shape (n,)."""
    acceleration: Array
    """Acceleration of the car [m/s^2], forward positive, shape (n,)."""


def missing(dynamic: list[WheelRun], sample_rate: float) -> list[str]:
    """Return what the dynamic drives lack, each in words; empty where they suffice."""
    found = []
    undriven = [run for run in dynamic if not run.wheel.driven]
    if sum(_revolutions(run, sample_rate, ACCELERATING) for run in undriven) < _FEWEST:
        found.append(
            f"a wheel that is not driven while the car accelerates by more than {ACCELERATING} m/s^2 (for beta): "
            f"{_FEWEST} revolutions"
        )
    if sum(_revolutions(run, sample_rate, BRAKING) for run in dynamic) < _FEWEST:
        found.append(f"braking below {BRAKING} m/s^2 (for the force maps): {_FEWEST} revolutions")
    return found


def _revolutions(run: WheelRun, sample_rate: float, beyond: float) -> int:
    time = np.array([passage.time for passage in run.passages]) / sample_rate
    acceleration = np.interp(time, run.time, run.acceleration)
    return int(np.count_nonzero(acceleration > beyond if beyond > 0.0 else acceleration < beyond))
