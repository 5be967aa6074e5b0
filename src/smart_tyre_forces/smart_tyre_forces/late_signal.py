"""A signal of the car at the time of a revolution that is some time past, whatever the order of arrival."""

from bisect import bisect_left, bisect_right
from collections import deque
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

DELAY: Final = 1.0
"""Time [s] after which the signals of a revolution have come."""
_REACH: Final = round(0.025 * NANOSECONDS)
"""Half the time over which a signal is averaged [ns]: engine and road shake the car as well."""
_KEPT: Final = round(3.0 * DELAY * NANOSECONDS)


class LateSignal:
    """Values of the last seconds."""

    def __init__(self) -> None:
        """Start empty."""
        self._stamps: deque[int] = deque()
        self._values: deque[float] = deque()

    def take(self, stamp: int, value: float) -> None:
        """Take a value with its stamp [ns]; one that goes back in time starts again."""
        if self._stamps and stamp <= self._stamps[-1]:
            self._stamps.clear()
            self._values.clear()
        self._stamps.append(stamp)
        self._values.append(value)
        while stamp - self._stamps[0] > _KEPT:
            self._stamps.popleft()
            self._values.popleft()

    def at(self, stamp: int) -> float | None:
        """Return the mean about a stamp [ns]; None where there is none, or the samples end before its end."""
        first, last = bisect_left(self._stamps, stamp - _REACH), bisect_right(self._stamps, stamp + _REACH)
        if first == last or last == len(self._stamps):
            return None
        return sum(self._values[k] for k in range(first, last)) / (last - first)
