"""The driver: line pressure over time, and speeds to drive at until braking."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class DriverProfile:
    """Nothing until `start`, a ramp to `pressure` within `rise`, `hold`, and a ramp back to nothing within `release`.

    A rise or release of 0 is a step.
    """

    pressure: float
    """Line pressure held [Pa], >= 0."""
    start: float
    """Start of the rise [s since the start of the run], >= 0."""
    rise: float
    """Duration of the rise [s], >= 0."""
    hold: float
    """Duration at full pressure [s], >= 0."""
    release: float
    """Duration of the release [s], >= 0."""

    def __post_init__(self) -> None:
        """Refuse negative values."""
        for name in ("pressure", "start", "rise", "hold", "release"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, is {getattr(self, name)}")

    def demand(self, time: float) -> float:
        """Line pressure [Pa] that the driver demands at `time` [s since the start of the run]."""
        since_start = time - self.start
        if since_start < 0.0:
            return 0.0
        if since_start < self.rise:
            return self.pressure * since_start / self.rise
        since_release = since_start - self.rise - self.hold
        if since_release < 0.0:
            return self.pressure
        if since_release < self.release:
            return self.pressure * (1.0 - since_release / self.release)
        return 0.0


FOLLOWING = 0.3
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
        self._gain = 0.5 * mass * radius / FOLLOWING

    def torque(self, time: float, speed: float) -> float:
        """Return the torque at each of two driven wheels [N m], >= 0, at `time` [s] and `speed` [m/s]."""
        return max(0.0, self._gain * (float(np.interp(time, self._times, self._speeds)) - speed))
