"""Wheel speeds from counters of encoder edges.

An edge is counted in one step or in the next: three edges in a hundredth of a second are a speed to within a third. So
a speed is the mean over as many steps as the fastest wheel needs for some twenty edges.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Final

from vehicle_models.nanoseconds import NANOSECOND, NANOSECONDS

_LONGEST_STEP: Final = NANOSECONDS // 10
"""A counter that was silent for longer [ns] may have wrapped: its next value begins anew. No mean is over more."""
_EDGES: Final = 20.0
"""Edges of the fastest wheel in a mean: its speed is known to 2 %."""

Values = Sequence[tuple[int, float]]
"""Place and value."""


class EdgeCounters:
    """Speeds of the wheels whose counters one source brings.

    A speed is the mean over the time between two values, and so that of its middle. A counter wraps: of the steps that
    it may have made, the one of less than half its range is taken, forward or backward.
    """

    def __init__(self, ranges: Mapping[int, float], pitches: Mapping[int, float]) -> None:
        """Start without values.

        Args:
            ranges: angle at which each counter wraps [rad], by place.
            pitches: angle of one edge [rad], by place.
        """
        self._ranges = ranges
        self._pitches = pitches
        self._last: dict[int, float] = {}
        self._kept: deque[tuple[int, dict[int, float]]] = deque()

    def speeds(self, stamp: int, angles: Values) -> tuple[int, Values] | None:
        """Take the counters as angles [rad]; return the middle of the time they are the mean of [ns], and the speeds.

        None at the first values, and where stamps repeat, go back or are more than 0.1 s apart. A speed [rad/s] is NaN
        where an angle is.
        """
        last, self._last, kept = self._last, dict(angles), self._kept
        if not last or not 0 < stamp - kept[-1][0] <= _LONGEST_STEP:
            self._begin(stamp)
            return None
        before = kept[-1][1]
        turned = {place: before[place] + self._step(place, angle - last[place]) for place, angle in angles}
        while len(kept) > 1 and (stamp - kept[0][0] > _LONGEST_STEP or self._is_enough(kept[1][1], turned)):
            kept.popleft()
        begin, then = kept[0]
        seconds = (stamp - begin) * NANOSECOND
        found = [(place, (turned[place] - then[place]) / seconds) for place, _ in angles]
        if all(isfinite(speed) for _, speed in found):
            kept.append((stamp, turned))
        else:
            self._begin(stamp)
        return (begin + stamp) // 2, found

    def reset(self) -> None:
        """Forget the last values."""
        self._last = {}
        self._kept.clear()

    def _begin(self, stamp: int) -> None:
        self._kept.clear()
        self._kept.append((stamp, dict.fromkeys(self._last, 0.0)))

    def _is_enough(self, then: Mapping[int, float], now: Mapping[int, float]) -> bool:
        return any(abs(now[place] - then[place]) >= _EDGES * self._pitches[place] for place in now)

    def _step(self, place: int, difference: float) -> float:
        period = self._ranges[place]
        return (difference + period / 2.0) % period - period / 2.0
