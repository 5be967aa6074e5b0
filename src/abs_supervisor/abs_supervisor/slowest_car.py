"""Least speed that a car can have after the wheel speeds that it had: no road lets it brake harder than 12 m/s^2."""

from math import nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

HARDEST_BRAKING: Final = 12.0
"""[m/s^2] of any car."""


class SlowestCar:
    """Follows wheels upwards at once, and downwards no faster than a car can brake."""

    def __init__(self) -> None:
        """Start without a speed."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._last: int | None = None
        self.speed = nan
        """[m/s], NaN before the first sample."""

    def update(self, stamp: int, rim: float) -> float:
        """Take the circumferential speed [m/s] of the fastest wheel at a stamp [ns]; return `speed`."""
        if self._last is not None:
            rim = max(rim, self.speed - HARDEST_BRAKING * (stamp - self._last) / NANOSECONDS, 0.0)
        self._last, self.speed = stamp, rim
        return rim
