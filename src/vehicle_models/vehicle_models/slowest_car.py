"""Least speed that a car can have after the wheel speeds that it had: one with locked wheels is not at rest."""

from math import nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

HARDEST_BRAKING: Final = 12.0
"""[m/s^2] of any car on any road."""


class SlowestCar:
    """Follows a wheel upwards at once, and downwards no faster than a car can brake."""

    def __init__(self, hardest_braking: float = HARDEST_BRAKING) -> None:
        """Start without a speed; `hardest_braking` is that of the car [m/s^2], > 0."""
        self._hardest_braking = hardest_braking
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._last: int | None = None
        self.speed = nan
        """[m/s], NaN before the first sample, then >= 0."""

    def update(self, stamp: int, rim: float) -> float:
        """Take the circumferential speed [m/s] of the fastest wheel at a stamp [ns]; return `speed`."""
        slowest = 0.0
        if self._last is not None:
            slowest = max(self.speed - self._hardest_braking * (stamp - self._last) / NANOSECONDS, 0.0)
        self._last, self.speed = stamp, max(rim, slowest)
        return self.speed
