"""Message stamps from and to integer nanoseconds."""

from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from friction_runtime.new_message import new_message
from vehicle_models.nanoseconds import NANOSECONDS


def to_nanoseconds(stamp: Time) -> int:
    """Nanoseconds [ns] of a message stamp."""
    return stamp.sec * NANOSECONDS + stamp.nanosec


def from_nanoseconds(nanoseconds: int) -> Time:
    """Message stamp of a time in nanoseconds [ns], >= 0."""
    time = new_message(Time)
    time.sec, time.nanosec = divmod(int(nanoseconds), NANOSECONDS)
    return time


def header_at(nanoseconds: int, frame_id: str) -> Header:
    """Header of a message that speaks of a time in nanoseconds [ns], >= 0."""
    header = new_message(Header)
    header.stamp = from_nanoseconds(nanoseconds)
    header.frame_id = frame_id
    return header
