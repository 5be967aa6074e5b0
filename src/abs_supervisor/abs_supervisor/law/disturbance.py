"""Disturbance torque compensation: the slow part, and the fast part beyond its noise."""

from typing import Final

_TIME: Final = 0.3
"""[s] of the slow part."""
_FIRST: Final = 0.05
"""[s] of it when it begins: the observer's own, in which its noise is averaged."""
_NOISE: Final = 0.25
"""Of the torque at the set-point: a faster part up to this counts as noise."""


class DisturbanceFilter:
    """Follows the disturbance torque of one wheel."""

    def __init__(self) -> None:
        """Start without."""
        self.reset()

    def reset(self) -> None:
        """Forget it."""
        self.slow = 0.0
        """Slow part [N m]."""
        self._learned = _FIRST

    def learn(self, disturbance: float, dt: float) -> None:
        """Take the disturbance torque [N m] of a sample, `dt` [s] after the last, into the slow part."""
        self._learned = min(self._learned + dt, _TIME)
        self.slow += (disturbance - self.slow) * min(dt / self._learned, 1.0)

    def followed(self, disturbance: float, steady: float) -> float:
        """Return the torque to follow [N m] of a disturbance torque [N m]; `steady` is that at the set-point [N m].

        Continuous: nothing of a fast part below a quarter of `steady`, all of it above a half.
        """
        fast = disturbance - self.slow
        size = abs(fast)
        share = min(max(2.0 * (size - _NOISE * steady), 0.0), size)
        return self.slow + (share if fast > 0.0 else -share)
