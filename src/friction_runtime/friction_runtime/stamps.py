"""Message stamps as integer nanoseconds: exact, ordered, and the only time the estimators know."""

from builtin_interfaces.msg import Time

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""


def to_nanoseconds(stamp: Time) -> int:
    """Nanoseconds [ns] of a message stamp."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def from_nanoseconds(nanoseconds: int) -> Time:
    """Message stamp of a time in nanoseconds [ns], >= 0."""
    seconds, rest = divmod(int(nanoseconds), NANOSECONDS)
    return Time(sec=seconds, nanosec=rest)
