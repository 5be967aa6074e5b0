"""Whether the road may have changed its slope: wheels that turn alike and the accelerometer differ, and go on to.

The accelerometer does not see a slope of the road: reading = acceleration + g sin(slope). So a step of the slope makes
wheels that roll, or slip steadily, change their speed by up to 1.5 m/s^2 more or less than the corrected reading says.
A wheel that dives differs by much more, for a shorter time, and not alike with the others. Wheels that slip steadily
decelerate by their slip less than the car.
"""

from collections.abc import Sequence
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

STEEPEST: Final = 1.5
"""What a road does at most [m/s^2]: a slope of 15 %."""
_LEAST: Final = 0.4
"""Difference between accelerations that noise does not make [m/s^2]."""
_STEADY_SLIP: Final = 0.08
"""Slip that may stay."""
_LASTING: Final = round(0.2 * NANOSECONDS)
"""Time for which the difference must last [ns]: a dive passes through all differences."""
_ALIKE: Final = round(0.5 * NANOSECONDS)
"""Time for which wheels have turned alike when none of them has dived lately [ns]."""


class SlopeWatch:
    """Follows the wheels of one car."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.mismatch = 0.0
        """Acceleration of the wheels minus that of the car [m/s^2] where a slope may be the reason, else 0."""
        self._unlike: int | None = None
        self._since: int | None = None

    def update(self, stamp: int, alike: bool, differences: Sequence[float], acceleration: float) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            alike: whether all wheels turn alike.
            differences: acceleration of each wheel minus that of the car [m/s^2], over a short window; finite.
            acceleration: of the car [m/s^2].
        """
        self.mismatch = 0.0
        if not alike:
            self._unlike = stamp
        if not differences or (self._unlike is not None and stamp - self._unlike < _ALIKE):
            self._since = None
            return
        difference = sorted(differences)[len(differences) // 2]
        if not _LEAST + _STEADY_SLIP * abs(acceleration) < abs(difference) < STEEPEST:
            self._since = None
            return
        if self._since is None:
            self._since = stamp
        if stamp - self._since >= _LASTING:
            self.mismatch = difference
