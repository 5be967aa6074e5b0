"""Wheel speeds from counters of encoder edges."""

from collections.abc import Mapping, Sequence
from typing import Final

from vehicle_models.nanoseconds import NANOSECOND, NANOSECONDS

_LONGEST_STEP: Final = NANOSECONDS // 10
"""A counter that was silent for longer [ns] may have wrapped: its next value begins anew."""

Values = Sequence[tuple[int, float]]
"""Place and value."""


class EdgeCounters:
    """Speeds of the wheels whose counters one source brings.

    A speed is the mean over the time between two values, and so that of its middle. A counter wraps: of the steps that
    it may have made, the one of less than half its range is taken, forward or backward.
    """

    def __init__(self, ranges: Mapping[int, float]) -> None:
        """Start without values; `ranges` is the angle at which each counter wraps [rad], by place."""
        self._ranges = ranges
        self._stamp = 0
        self._angles: dict[int, float] = {}

    def speeds(self, stamp: int, angles: Values) -> tuple[int, Values] | None:
        """Take the counters as angles [rad]; return the middle of the step [ns] and the speeds [rad/s].

        None at the first values, and where stamps repeat, go back or are more than 0.1 s apart. A speed is NaN where an
        angle is.
        """
        before, last = self._stamp, self._angles
        self._stamp, self._angles = stamp, dict(angles)
        if not last or not 0 < stamp - before <= _LONGEST_STEP:
            return None
        seconds = (stamp - before) * NANOSECOND
        found = [(place, self._step(place, angle - last[place]) / seconds) for place, angle in angles]
        return (before + stamp) // 2, found

    def reset(self) -> None:
        """Forget the last values."""
        self._angles = {}

    def _step(self, place: int, difference: float) -> float:
        period = self._ranges[place]
        return (difference + period / 2.0) % period - period / 2.0
