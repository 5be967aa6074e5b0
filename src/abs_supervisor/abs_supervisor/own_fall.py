"""Slip relative to the wheel's own recent maximum, extrapolated with vehicle deceleration.

The speed of the car errs by what its accelerometer errs by, added up over the whole stop, and slip with it. The change
of slip in the last second does not, and a braked wheel has never less slip than none: what it has lost since is slip.
"""

from math import isfinite, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_LEAST: Final = 0.05
"""Of its speed, by which a wheel falls: with less it is kept so quiet that it no longer tells the speed of its car."""
_FORGETS: Final = 0.1
"""[m/s^2] by which the speed that is carried on falls faster than the car: errors do not add up."""
_SMOOTH: Final = 0.02
"""[s] over which the wheel's speed is averaged."""
_NOISE: Final = 0.5
"""Of the noise of a sample is left then."""
_TELLS: Final = 0.5
"""[m/s] of its speed from which on the share means anything."""
_GAP: Final = 0.1
"""[s] after a longer gap it begins anew."""


class OwnFall:
    """Follows one wheel."""

    def __init__(self, sigmas: float) -> None:
        """Choose by how many standard deviations of its noise a wheel falls more than that."""
        self._sigmas = sigmas
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.holds = False
        """Whether it has fallen behind."""
        self._carried = self._rim = nan
        self._stamp = 0

    @property
    def share(self) -> float:
        """By how much it has fallen behind, as a share of the speed that it would have."""
        return 1.0 - self._rim / self._carried if self._carried > _TELLS else 0.0

    def update(self, stamp: int, rim: float, noise: float, car_deceleration: float) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            rim: speed of the wheel's circumference [m/s].
            noise: standard deviation of its noise [m/s].
            car_deceleration: [m/s^2], NaN where unknown.
        """
        dt = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        if dt > _GAP or not isfinite(car_deceleration + self._carried):
            self._carried = self._rim = rim
            self.holds = False
            return
        self._rim += (rim - self._rim) * min(dt / _SMOOTH, 1.0)
        # A car that seems to gain speed under braking has a speed that jumps.
        self._carried = max(self._carried - (max(car_deceleration, 0.0) + _FORGETS) * dt, self._rim)
        self.holds = self._carried - self._rim > _LEAST * self._carried + self._sigmas * _NOISE * noise
