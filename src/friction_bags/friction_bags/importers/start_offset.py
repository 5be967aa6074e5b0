"""Puts logs that count from their own beginning later: a stamp of 0 s is no stamp."""

from typing import Final

START_OFFSET: Final = 1000
"""By how much such a log is put later [s]."""
_EARLIEST: Final = 1.0
"""A log that begins before it counts from its beginning [s]."""


def start_offset(first: float) -> int:
    """Return what to add to the times of a log whose first time is `first` [s]; NaN is no time and asks for nothing."""
    return START_OFFSET if first < _EARLIEST else 0
