"""One wheel in one drive of a calibration."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.patch_tracker import Passage
from vehicle_models.vehicle import Wheel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WheelRun:
    """Passages of one wheel in one drive."""

    wheel: Wheel
    passages: list[Passage]
    time: Array
    """Times of the car's acceleration, on the time scale of the passages [s], increasing, shape (n,)."""
    acceleration: Array
    """Acceleration of the car [m/s^2], forward positive, shape (n,)."""
