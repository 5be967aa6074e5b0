"""Detects excessive accelerometer latency: all wheels lose speed while it still reads zero.

A wheel slips by more than some percent only where its brake and the road pull at it, and the road pulls at the car as
much: on the softest snow a force of `_FORCELESS` makes 2 % of slip. It builds up within a length of the tyre. So wheels
that have lost more than that and go on to, while the accelerometer has read no force since they rolled, tell of a
reading that is not that of now. On ice that bears no more than such a force this is wrong, and the slip is UNCERTAIN.
"""

from collections import deque
from collections.abc import Sequence
from math import inf, isfinite
from typing import Final, NamedTuple

from friction_runtime.filters import Debounce, FirstOrderFilter
from vehicle_models.nanoseconds import NANOSECONDS

_WINDOW: Final = NANOSECONDS // 2
"""[ns] over which the loss of the wheels is taken."""
_FORCELESS: Final = 0.6
"""Force of all tyres over the mass of the car [m/s^2] that counts as none."""
_LAG: Final = 0.015
"""Time constant [s] of the mean of the readings: that of the filter of a wheel."""
_SLIP: Final = 0.015
"""Slip by such a force, at most."""
_NOISE: Final = 0.15
"""What wheels may lose besides [m/s]."""
_BUILD_UP: Final = 0.04
_LENGTH: Final = 0.6
"""Time [s] and way [m] in which the force of a dive is felt: brake, filter of the accelerometer; tyre."""
_SLOWEST: Final = 5.0
"""[m/s] below which wheels are not judged."""
_GAP: Final = NANOSECONDS // 10
"""Longer steps between samples [ns] are gaps."""
_FOR: Final = 30 * NANOSECONDS
"""[ns] for which it is left out then."""


class UnfeltDive:
    """The accelerometer of one car beside its wheels."""

    def __init__(self, delay: float) -> None:
        """Start without samples; `delay` is by how much the accelerometer may be late as far as is known [s]."""
        self._build_up = _BUILD_UP + delay
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._until = 0
        self._start_again()

    def _start_again(self) -> None:
        self._kept: deque[_Sample] = deque()
        self._force = FirstOrderFilter(_LAG)
        self._last: int | None = None
        self._all_lose = Debounce()

    def holds(self, stamp: int) -> bool:
        """Whether the accelerometer is left out at a stamp [ns]."""
        return stamp < self._until

    def update(self, stamp: int, rim_speeds: Sequence[float], acceleration: float, rolling: bool) -> None:
        """Take one sample.

        Args:
            stamp: [ns], later than the last.
            rim_speeds: filtered r omega of the wheels [m/s], NaN where unknown.
            acceleration: reading less the offset that is known [m/s^2].
            rolling: whether all wheels rolled at the last sample.
        """
        if self._last is not None and stamp - self._last > _GAP:
            self._start_again()
        dt = 0.0 if self._last is None else (stamp - self._last) / NANOSECONDS
        self._last = stamp
        kept = self._kept
        if abs(self._force.update(dt, acceleration)) >= _FORCELESS:
            kept.clear()
            self._all_lose.reset()
            return
        if kept:
            travelled = kept[-1].travelled + dt * acceleration
        elif rolling:
            travelled = 0.0
        else:
            return
        kept.append(_Sample(stamp, rim_speeds, travelled))
        while stamp - kept[0].stamp > _WINDOW:
            kept.popleft()
        before = kept[0].rim_speeds
        change = travelled - kept[0].travelled
        losses = [then + change - now for then, now in zip(before, rim_speeds, strict=True)]
        losses = sorted([loss for loss in losses if isfinite(loss)])
        speed = max([each for each in before if isfinite(each)], default=0.0)
        # One of several may have failed; in a curve some wheels lose what others gain.
        all_lose = len(losses) > 1 and losses[1] > _SLIP * speed + _NOISE
        fast = speed >= _SLOWEST
        self._all_lose.duration = (self._build_up + _LENGTH / speed) * NANOSECONDS if fast else inf
        if self._all_lose.update(stamp, fast and all_lose):
            self._until = stamp + _FOR
            self._start_again()


class _Sample(NamedTuple):
    """One time; the reading integrated since the first one [m/s]."""

    stamp: int
    rim_speeds: Sequence[float]
    travelled: float
