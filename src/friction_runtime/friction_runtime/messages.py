"""Parts of messages: stamps in integer nanoseconds, headers, validity with its text, the usable part of a slip."""

from builtin_interfaces.msg import Time
from friction_msgs.msg import Validity, WheelSlip
from std_msgs.msg import Header

from friction_runtime.reports import of_topic, of_wheel
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_SLIP, HIGHEST_SLIP_RATE, HIGHEST_SPEED, is_vague
from vehicle_models.reason import Reason


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


def validity(wheel: str, reason: Reason, text: str) -> Validity:
    """Return a message Validity.

    Args:
        wheel: name of the wheel that the estimate is of.
        reason: why it may not be used.
        text: the reason in words, empty where it is OK.
    """
    return Validity(valid=reason == Reason.OK, reason=int(reason), text=of_wheel(wheel, text))


_ORDINARY = (Reason.OK, Reason.NOT_READY, Reason.LOW_SPEED)
"""Reasons that belong to ordinary driving."""


def slip_fault(topic: str, message: WheelSlip) -> str:
    """Return why the slip received on `topic` degrades what is made of it; empty in ordinary driving."""
    return "" if message.validity.reason in _ORDINARY else of_topic(topic, message.validity.text)


def slip_is_known(message: WheelSlip) -> bool:
    """Whether slip and slip rate are valid, and those of a wheel on a road; NaN is neither."""
    plausible = abs(message.slip) <= HIGHEST_SLIP and abs(message.slip_rate) <= HIGHEST_SLIP_RATE
    return bool(message.validity.valid and plausible)


def speed_is_known(message: WheelSlip) -> bool:
    """Whether the message has a usable speed of the car: not NaN, and not too uncertain."""
    speed = message.vehicle_speed
    return bool(abs(speed) <= HIGHEST_SPEED and not is_vague(speed, message.vehicle_speed_stddev))
