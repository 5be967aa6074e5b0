"""The driver's right foot: speeds to drive at, until the left one brakes."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

_FOLLOWING = 0.3
"""Time constant [s] with which the driver comes to the speed he wants."""


class Throttle:
    """Torque of the engine that makes a car follow speeds over time, straight from one to the next."""

    def __init__(self, times: Sequence[float], speeds: Sequence[float], mass: float, radius: float) -> None:
        """Plan the drive.

        Args:
            times: when each speed is to be reached [s since the start of the run], increasing.
            speeds: the speeds [m/s], same length; the last one holds on. All 0: the car rolls in neutral.
            mass: of the car [kg].
            radius: of the driven wheels [m].

        Raises:
            ValueError: times and speeds do not fit each other.
        """
        if len(times) != len(speeds) or not all(a < b for a, b in pairwise(times)):
            raise ValueError(
                f"'car.drive_times' = {list(times)} must increase and be as many as 'car.drive_speeds' = {list(speeds)}"
            )
        self._times, self._speeds = np.array(times), np.array(speeds)
        self._gain = 0.5 * mass * radius / _FOLLOWING

    def torque(self, time: float, speed: float) -> float:
        """Return the torque at each of two driven wheels [N m], >= 0, at `time` [s] and `speed` [m/s]."""
        return max(0.0, self._gain * (float(np.interp(time, self._times, self._speeds)) - speed))
