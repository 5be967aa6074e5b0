"""Speed dropout check: a wheel speed that falls to zero faster than brake and road allow.

The longer it stands the more of the fall its brake could have caused: only the first sample tells. A wheel that is
braked hard, or that dives, is else taken for a locked one, as soon as its brake could have locked it.
"""

from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_STAMP_ERROR: Final = 0.002
"""[s] by which two stamps may be further apart than stated."""
_TURNED: Final = 0.05
"""[s] for which the wheel must have turned before: a spike of a wheel that stands is no fall."""
_TELLS_ABOVE: Final = 3.0
"""[m/s] of the circumference; below it the signal of a passive sensor vanishes, and it reads 0."""


class SuddenStop:
    """Follows one wheel. `suspected` is for the caller to confirm by time: a spike ends sooner."""

    def __init__(self, radius: float, jitter: float) -> None:
        """Choose a wheel of effective radius [m] whose speed may err by `jitter` [rad/s]."""
        self._radius, self._jitter = radius, jitter
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._turned: tuple[int, int, float] | None = None
        """Stamps [ns] since when, and until when, the wheel is known to have turned, and its last speed [rad/s]."""
        self.suspected = False
        """Whether the wheel stands since a sample at which it cannot have stood."""

    def update(self, stamp: int, speed: float, stands: bool, trusted: bool, hardest: float) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            speed: of the wheel [rad/s].
            stands: whether the wheel stands by it.
            trusted: whether the speed is one that the wheel can have.
            hardest: deceleration that the brake can give on a road without friction [rad/s^2].
        """
        if not stands:
            self.suspected = False
            if trusted:
                since = stamp if self._turned is None else self._turned[0]
                self._turned = (since, stamp, speed)
            return
        if self._turned is None or self.suspected:
            return
        since, at, before = self._turned
        fall = hardest * ((stamp - at) / NANOSECONDS + _STAMP_ERROR) + self._jitter
        turned = at - since >= _TURNED * NANOSECONDS and before * self._radius > _TELLS_ABOVE
        self.suspected = turned and before - fall > speed
        if not self.suspected:
            self._turned = None
