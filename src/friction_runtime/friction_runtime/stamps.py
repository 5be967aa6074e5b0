"""Message stamps from and to integer nanoseconds."""

from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from vehicle_models.nanoseconds import NANOSECONDS


def to_nanoseconds(stamp: Time) -> int:
    """Return a message stamp in nanoseconds [ns]."""
    seconds: int = stamp.sec
    rest: int = stamp.nanosec
    return seconds * NANOSECONDS + rest


def from_nanoseconds(nanoseconds: int) -> Time:
    """Return the message stamp of a time in nanoseconds [ns], >= 0."""
    return Time(sec=nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


def header_at(nanoseconds: int, frame_id: str) -> Header:
    """Return the header of a message for a time in nanoseconds [ns], >= 0."""
    return Header(stamp=from_nanoseconds(nanoseconds), frame_id=frame_id)
