"""Crossings across missing teeth: a broken tooth, or the mark of a ring such as 60-2.

Where teeth are missing the sine stays near zero, and of their crossings at most one or two are seen, anywhere in the
gap. Once the crossings are regular again, their number in between follows from the time it took; it is even or odd as
the number of those seen, because crossings alternate between rising and falling. So whatever the gap holds is replaced
by evenly spaced crossings, and the ring counts as whole: its tooth table learns what is left.
"""

import numpy as np

_MOST_MISSING = 3
"""Most teeth that may be missing in a row."""
_MOST_SEEN = 4
"""Crossings after which the teeth must be regular again."""
_DOUBT = 0.5
"""Largest distance of the counted intervals from the time that they took [intervals]; the next count is 2 away."""


class Gap:
    """One gap, from the last regular crossing before it."""

    def __init__(self, begin: float, interval: float, time: float, ratio: float) -> None:
        """Begin.

        Args:
            begin: last regular crossing [samples].
            interval: interval before it [samples].
            time: first crossing after it, which came late [samples].
            ratio: largest ratio of intervals that count as alike.
        """
        self._begin, self._interval, self._ratio = begin, interval, ratio
        self._seen = [time]

    @property
    def newest(self) -> float:
        """Newest crossing [samples]."""
        return self._seen[-1]

    @property
    def may_be_bridged(self) -> bool:
        """Whether the next crossing may still end the gap."""
        return len(self._seen) < _MOST_SEEN and self.newest - self._begin < 4 * _MOST_MISSING * self._interval

    def bridge(self, time: float) -> list[float] | None:
        """Take the next crossing [samples]; return all crossings of the gap and this one once the gap is over."""
        end, alike = self.newest, time - self.newest
        seen = len(self._seen)
        self._seen.append(time)
        if not 1.0 / self._ratio < alike / self._interval < self._ratio:
            return None
        intervals = 2.0 * (end - self._begin) / (self._interval + alike)
        count = seen + 2 * round(0.5 * (intervals - seen))
        if count < seen or abs(count - intervals) > _DOUBT or count > 2 * _MOST_MISSING + 2:
            return None
        if count == seen:
            return [*self._seen]
        return [*np.linspace(self._begin, end, count + 1)[1:].tolist(), time]
