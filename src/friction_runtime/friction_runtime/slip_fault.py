"""Usable part of a slip estimated by another node, and its fault."""

from friction_msgs.msg import WheelSlip

from friction_runtime.reason_text import of_topic
from vehicle_models.physical_bounds import HIGHEST_SLIP, HIGHEST_SLIP_RATE, HIGHEST_SPEED, is_vague
from vehicle_models.reason import Reason

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
