"""Second witness of a wheel beyond its peak, which shares no error with slip, speed and curve: the wheel itself.

Slip and curve may be valid and wrong, and then both ask for a release in a braking that is none of a lock. A wheel that
is beyond its peak loses speed although its brake does not rise; one before it keeps its slip. So the brake is held for
a moment, which takes nothing from it, and the wheel is looked at: hold, then look. Once a wheel has been seen to slip,
the torque that the road gave then is the witness for the rest of the braking (road_torque.py).
"""

from math import isfinite, nan
from typing import Final

from abs_supervisor.wheel_motion import WINDOW
from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS

_SMOOTH: Final = 0.015
"""[s] over which a brake torque is averaged, to see whether it rises."""
_NOISE, _NOISE_SHARE = 5.0, 0.02
"""[N m] and share of it by which a brake torque that does not rise may be above that."""
_LOOK_TIME: Final = round(0.1 * NANOSECONDS)
"""[ns] for which a brake is held to see what the wheel does, and after which its pressure rises for as long."""


class Witness:
    """Of one wheel."""

    def __init__(self, lasts: float) -> None:
        """Choose how long it has to last [s]."""
        self._lasts = Debounce(round(lasts * NANOSECONDS))
        # The wheel's deceleration is that over a window: a rise counts until it has left that.
        self._still = Debounce(round(WINDOW * NANOSECONDS))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._lasts.reset()
        self._still.reset()
        self._torque = nan
        self._stamp = 0
        self._asked, self._since = -2 * _LOOK_TIME, 0
        self.confirms = False
        """Whether the wheel itself shows that it slips."""

    def update(self, stamp: int, torque: float, diverges: bool, fell: bool) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            torque: of the brake [N m].
            diverges: whether the wheel loses speed faster than its car, and than a wheel before its peak does.
            fell: whether it has lost more of its own speed than any wheel before its peak.
        """
        dt = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        if not isfinite(self._torque):
            self._torque = torque
        self._torque += (torque - self._torque) * min(dt / _SMOOTH, 1.0)
        rises = torque - self._torque > _NOISE + _NOISE_SHARE * torque
        still = self._still.update(stamp, not rises)
        self.confirms = self._lasts.update(stamp, fell or (diverges and still))

    def looks(self, stamp: int, asked: bool) -> bool:
        """Return whether to hold the brake now, at the stamp [ns] of the last `update`, to look at the wheel.

        `asked` is whether slip and curve alone ask for a release.
        """
        if not asked:
            return False
        if stamp - self._asked > _LOOK_TIME:
            self._since = stamp
        self._asked = stamp
        return (stamp - self._since) % (2 * _LOOK_TIME) < _LOOK_TIME
