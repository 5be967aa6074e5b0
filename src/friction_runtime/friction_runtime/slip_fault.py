"""Usable part of a slip estimated by another node, and its fault."""

from friction_msgs.msg import WheelSlip

from friction_runtime.reason_text import of_topic
from vehicle_models.physical_bounds import HIGHEST_SLIP, HIGHEST_SLIP_RATE, HIGHEST_SPEED, is_vague

_ORDINARY = (int(WheelSlip.OK), int(WheelSlip.NOT_READY), int(WheelSlip.LOW_SPEED))
"""Reasons that belong to ordinary driving."""


def slip_fault(topic: str, message: WheelSlip) -> str:
    """Return why the slip received on `topic` degrades what is made of it; empty in ordinary driving."""
    return "" if message.reason in _ORDINARY else of_topic(topic, message.reason_text)


def slip_is_known(message: WheelSlip) -> bool:
    """Whether slip and slip rate are valid, and those of a wheel on a road; NaN is neither."""
    return bool(message.valid and abs(message.slip) <= HIGHEST_SLIP and abs(message.slip_rate) <= HIGHEST_SLIP_RATE)


def speed_is_known(message: WheelSlip) -> bool:
    """Whether the message has a usable speed of the car: not NaN, and not too uncertain."""
    speed = message.vehicle_speed
    return bool(abs(speed) <= HIGHEST_SPEED and not is_vague(speed, message.vehicle_speed_variance))
