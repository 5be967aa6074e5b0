"""Message stamps from and to integer nanoseconds."""

from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from friction_runtime.new_message import new_message
from vehicle_models.nanoseconds import NANOSECONDS


def to_nanoseconds(stamp: Time) -> int:
    """Return a message stamp in nanoseconds [ns]."""
    seconds: int = stamp.sec
    rest: int = stamp.nanosec
    return seconds * NANOSECONDS + rest


def from_nanoseconds(nanoseconds: int) -> Time:
    """Return the message stamp of a time in nanoseconds [ns], >= 0."""
    time = new_message(Time)
    time.sec, time.nanosec = nanoseconds // NANOSECONDS, nanoseconds % NANOSECONDS
    return time


def header_at(nanoseconds: int, frame_id: str) -> Header:
    """Return the header of a message for a time in nanoseconds [ns], >= 0."""
    header = new_message(Header)
    header.stamp = from_nanoseconds(nanoseconds)
    header.frame_id = frame_id
    return header
