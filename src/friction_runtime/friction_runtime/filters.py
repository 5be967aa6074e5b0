"""Filters on the times of samples: debounce, first-order low-pass, sliding window and its maximum.

Times are all in one unit, which the caller chooses: nanoseconds of stamps, or seconds.
"""

from collections import deque
from collections.abc import Iterator
from math import exp
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Debounce:
    """True once a condition has held at every sample for a time."""

    __slots__ = ("duration", "since")

    def __init__(self, duration: float = 0.0) -> None:
        """Set the time for which the condition has to hold, >= 0."""
        self.duration = duration
        self.since: float | None = None
        """Time of the first sample at which the condition has held without a break, None where it does not."""

    def reset(self) -> None:
        """Begin again."""
        self.since = None

    def update(self, time: float, condition: bool) -> bool:
        """Take a sample; return whether the condition has held for long enough."""
        if not condition:
            self.since = None
            return False
        if self.since is None:
            self.since = time
        return time - self.since >= self.duration

    def elapsed(self, time: float) -> float:
        """Return for how long the condition has held, 0 where it does not."""
        return 0.0 if self.since is None else time - self.since


def first_order_gain(dt: float, time_constant: float) -> float:
    """Return the weight of a new sample in a first-order low-pass."""
    return 1.0 - exp(-dt / time_constant)


class SlidingWindow(Generic[Value]):
    """Samples that are no older than a horizon, the oldest first."""

    __slots__ = ("_samples", "horizon")

    def __init__(self, horizon: float) -> None:
        """Start empty."""
        self.horizon = horizon
        self._samples: deque[tuple[float, Value]] = deque()

    def __len__(self) -> int:
        return len(self._samples)

    def __iter__(self) -> Iterator[tuple[float, Value]]:
        """Times and values, the oldest first."""
        return iter(self._samples)

    def append(self, time: float, value: Value) -> None:
        """Take the newest sample; drop those that are too old."""
        self._samples.append((time, value))
        self.drop_old(time)

    def drop_old(self, time: float) -> None:
        """Drop the samples that are older than the horizon at a time."""
        samples, begin = self._samples, time - self.horizon
        while samples and samples[0][0] < begin:
            samples.popleft()

    def clear(self) -> None:
        """Drop all samples."""
        self._samples.clear()


class SlidingMaximum:
    """Largest value of the samples that are no older than a horizon."""

    __slots__ = ("_candidates", "_horizon")

    def __init__(self, horizon: float) -> None:
        """Start empty."""
        self._horizon = horizon
        self._candidates: deque[tuple[float, float]] = deque()

    def update(self, time: float, value: float) -> float:
        """Take the newest sample; return the largest value."""
        candidates, begin = self._candidates, time - self._horizon
        while candidates and candidates[-1][1] <= value:
            candidates.pop()
        candidates.append((time, value))
        while candidates[0][0] < begin:
            candidates.popleft()
        return candidates[0][1]

    def clear(self) -> None:
        """Drop all samples."""
        self._candidates.clear()
