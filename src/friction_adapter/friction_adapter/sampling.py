"""Samples of one instant from several sources, and wheel speeds from counters of encoder edges.

An edge is counted in one step or in the next: three edges in a hundredth of a second are a speed to within a third. So
a speed is the mean over as many steps as the fastest wheel needs for some twenty edges.
"""

from collections import deque
from collections.abc import Collection, Mapping, Sequence
from math import isfinite, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECOND, NANOSECONDS

Sent = tuple[int, list[float]]
"""Stamp [ns] and values, NaN where there is none."""
_LONGEST_STEP: Final = NANOSECONDS // 10
"""A counter that was silent for longer [ns] may have wrapped: its next value begins anew. No mean is over more."""
_EDGES: Final = 20.0
"""Edges of the fastest wheel in a mean: its speed is known to 2 %."""

Values = Sequence[tuple[int, float]]
"""Place and value."""


class SampleGrouping:
    """Combines the values of several sources at one instant.

    An instant ends with the last of its sources. It ends without those that are missing, whose values are then NaN,
    when a source speaks again or one speaks of another time: no value is ever taken into another instant.
    """

    def __init__(self, sources: Collection[str], size: int, window: int) -> None:
        """Start without values.

        Args:
            sources: names of the sources.
            size: number of values.
            window: stamps of one instant are at most this far apart [ns].
        """
        self._sources = frozenset(sources)
        self._size = size
        self._window = window
        self._seen: set[str] = set()
        self._stamp = 0
        self._values = [nan] * size
        self.incomplete = 0
        """Instants that ended without one of their sources."""

    def add(self, source: str, stamp: int, values: Sequence[tuple[int, float]]) -> list[Sent]:
        """Take the values of one source.

        Args:
            source: its name.
            stamp: their stamp [ns]; that of the first source is the stamp of the instant.
            values: place and value of each.

        Returns:
            The instants that this ends: none, one, or an incomplete one and this one.
        """
        ended = []
        if self._seen and (source in self._seen or abs(stamp - self._stamp) > self._window):
            self.incomplete += 1
            ended.append(self._end())
        if not self._seen:
            self._stamp = stamp
        self._seen.add(source)
        for place, value in values:
            self._values[place] = value
        if self._seen == self._sources:
            ended.append(self._end())
        return ended

    def reset(self) -> None:
        """Forget an instant that has begun."""
        self._end()
        self.incomplete = 0

    def _end(self) -> Sent:
        sent = self._stamp, self._values
        self._seen = set()
        self._values = [nan] * self._size
        return sent


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
