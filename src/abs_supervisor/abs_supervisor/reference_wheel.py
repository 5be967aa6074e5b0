"""Reference release: a rear wheel rolls briefly so that a long slide keeps a speed reference.

Where the speed of the car is integrated, a slip that is held at its peak says nothing of that speed. On a slope that
begins during the stop all wheels creep with its error: uphill to no slip, downhill into a lock. Braked wheels tell
nothing of that, one without brake does as soon as its tyre has sprung back. On a road with grip the car stands before
such an error is as large as the slip that is held; elsewhere one rear wheel after the other rolls once in a while.

It belongs to the envelope, which says whether a wheel may: it has slipped in this braking by evidence, its slip is that
of a release, and the driver asks for more than the road gives. How long and how often is bounded whatever is measured.
"""

from collections.abc import Sequence
from math import isfinite, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_SLOPE: Final = 0.6
"""[m/s^2] by which the road may change unseen: a hill of 6 %."""
_OFTEN: Final = 2.0
"""[s] from one to the next at least."""
_CONFIRMED: Final = 2.0
"""Times as much, once a wheel has shown that the speed was right."""
_AGAIN: Final = 0.5
"""Times as much, once one has shown that it was wrong: the slope is not known yet."""
_WRONG: Final = 0.015
"""Of the speed: it was wrong if it changes by more from one sample to the next."""
_OPEN: Final = 40.0
"""[N m] a brake is open below."""
_WAY: Final = 1.6
"""[m] within which a tyre springs back: several of its relaxation lengths."""
_STANDS: Final = 0.045
"""[s] for which the wheel is then seen to turn with the car."""
_LONGEST: Final = 0.35
"""[s] from the first command on, whatever is measured."""
_ABOVE: Final = 7.0
"""[m/s] below, the wheel would roll for too long."""
_AGAIN_ABOVE: Final = 4.0
"""[m/s] The same once the speed was wrong."""
_FORGETS: Final = 0.2
"""[s] without a sample, after which another braking begins."""


class ReferenceWheel:
    """The wheels of one car: says which one is to roll. Each asks at each of its samples."""

    def __init__(self, wheels: Sequence[str]) -> None:
        """Choose the wheels that take turns."""
        self._turns = list(wheels)
        self._newest = 0
        self.reset()

    def reset(self) -> None:
        """Begin another braking."""
        self._since: int | None = None
        self._rolling = ""
        self._began = 0
        self._opened: int | None = None
        self._speed = nan
        self._wait, self._above = 1.0, _ABOVE

    def rolls(self, wheel: str, stamp: int, speed: float, deceleration: float, torque: float, held: float) -> bool:
        """Return whether a wheel is to roll.

        Args:
            wheel: its name.
            stamp: of the sample [ns].
            speed: of the car [m/s], integrated; NaN where it is not, or not known.
            deceleration: of the car [m/s^2], NaN where unknown.
            torque: of the brake [N m].
            held: slip that its law holds below the demand [-]; NaN where it does not.
        """
        if not -_FORGETS * NANOSECONDS < stamp - self._newest < _FORGETS * NANOSECONDS:
            self.reset()
        self._newest = stamp
        if abs(speed - self._speed) > _WRONG * speed:
            self._wait, self._above = _AGAIN, _AGAIN_ABOVE
        self._speed = speed
        if self._rolling and stamp - self._began > _LONGEST * NANOSECONDS:
            self._end(stamp)
        if self._rolling:
            return self._rolling == wheel and self._goes_on(stamp, speed, torque)
        if self._turns[0] != wheel or not isfinite(held) or not speed > self._above:
            return False
        if self._since is None:
            self._since = stamp
        # The car stands before its speed is wrong by as much as the slip that is held.
        if not deceleration * held < _SLOPE:
            return False
        wait = self._wait * max(held * speed / _SLOPE, _OFTEN)
        if stamp - self._since < wait * NANOSECONDS:
            return False
        self._turns = [*self._turns[1:], wheel]
        self._rolling, self._began, self._opened = wheel, stamp, None
        self._wait, self._above = _CONFIRMED, _ABOVE
        return True

    def _goes_on(self, stamp: int, speed: float, torque: float) -> bool:
        if self._opened is None and torque < _OPEN:
            self._opened = stamp
        rolled = 0.0 if self._opened is None else (stamp - self._opened) / NANOSECONDS
        if not speed > 0.0 or rolled > _WAY / speed + _STANDS:
            self._end(stamp)
        return bool(self._rolling)

    def _end(self, stamp: int) -> None:
        self._rolling, self._since = "", stamp
