"""Values of one message from several sources: sent with the last of one instant, never interpolated."""

from collections.abc import Collection, Sequence
from math import nan

Values = list[float]
Sent = tuple[int, Values]
"""Stamp [ns] and values, NaN where there is none."""


class Instants:
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
