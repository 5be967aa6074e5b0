"""Deceleration of the car from its speed at two times."""

from collections import deque
from math import isfinite, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

WINDOW: Final = 0.2
"""[s]"""


class SpeedTrend:
    """Follows a speed; `deceleration` is its mean over the window."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._samples: deque[tuple[int, float]] = deque()
        self.deceleration = nan
        """[m/s^2], braking positive; NaN until the speed is known for half a window."""

    def update(self, stamp: int, speed: float) -> None:
        """Take the speed [m/s] at a stamp [ns], NaN where unknown."""
        samples = self._samples
        if not isfinite(speed):
            samples.clear()
            self.deceleration = nan
            return
        samples.append((stamp, speed))
        while len(samples) > 2 and samples[1][0] <= stamp - WINDOW * NANOSECONDS:
            samples.popleft()
        begin, first = samples[0]
        seconds = (stamp - begin) / NANOSECONDS
        self.deceleration = (first - speed) / seconds if seconds >= 0.5 * WINDOW else nan
