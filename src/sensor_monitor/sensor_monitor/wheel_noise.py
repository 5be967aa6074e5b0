"""Wheel-speed noise, estimated where it exceeds the specified one (coarse counters, loose sensors).

What wheels that turn alike differ by from their mean, x, changes slowly: by curves and slips. So its second differences
over a step L of time are noise, of a variance R in each of n wheels:

    mean of (x(t) - 2 x(t - L) + x(t - 2 L))^2 = 6 R (1 - 1/n)
"""

from collections import deque
from collections.abc import Sequence
from math import isfinite
from typing import Final

from sensor_monitor.signal_noise import MORE
from vehicle_models.nanoseconds import NANOSECONDS

_STEP: Final = NANOSECONDS // 20
"""L [ns]: longer than a count of a coarse counter lasts at the speed of a car that drives."""
_GAP: Final = 3 * _STEP
_MEMORY: Final = 40
"""Differences of the mean: 2 s."""
_FIRST: Final = 10
"""Differences from which on there is one."""


class WheelNoise:
    """Of the wheels of one car. `variance` is the one that counts [rad^2/s^2]."""

    def __init__(self, stated: float) -> None:
        """Start with what is stated: a variance [rad^2/s^2]."""
        self._stated = stated
        self.reset()

    def reset(self) -> None:
        """Know what is stated."""
        self.variance = self._stated
        self._seen = self._stated
        self._count = 0
        self._kept: deque[tuple[int, list[float]]] = deque(maxlen=3)

    def update(self, stamp: int, wheel_speeds: Sequence[float], alike: bool) -> None:
        """Take one sample.

        Args:
            stamp: [ns], later than the last.
            wheel_speeds: as measured [rad/s].
            alike: whether the wheels turn alike.
        """
        kept = self._kept
        if not alike or len(wheel_speeds) < 2 or not all([isfinite(each) for each in wheel_speeds]):
            kept.clear()
            return
        if kept:
            since = stamp - kept[-1][0]
            if since < _STEP:
                return
            if since > _GAP:
                kept.clear()
        mean = sum(wheel_speeds) / len(wheel_speeds)
        kept.append((stamp, [each - mean for each in wheel_speeds]))
        if len(kept) < 3:
            return
        count = len(wheel_speeds)
        squares = [(a - 2.0 * b + c) ** 2 for a, b, c in zip(kept[0][1], kept[1][1], kept[2][1], strict=True)]
        found = sum(squares) / (6.0 * (count - 1.0))
        self._count += 1
        self._seen += (found - self._seen) / min(self._count + 1, _MEMORY)
        if self._count >= _FIRST:
            # Not below: a wheel filter of too much noise lags.
            self.variance = self._seen if self._seen > MORE * self._stated else self._stated
