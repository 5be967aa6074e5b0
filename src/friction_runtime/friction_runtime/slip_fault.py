"""What is wrong with a slip that another node has estimated."""

from friction_msgs.msg import WheelSlip

from friction_runtime.reason_text import of_topic

_ORDINARY = (int(WheelSlip.OK), int(WheelSlip.NOT_READY), int(WheelSlip.LOW_SPEED))
"""Reasons that belong to ordinary driving."""


def slip_fault(topic: str, message: WheelSlip) -> str:
    """Return why the slip received on `topic` degrades what is made of it; empty in ordinary driving."""
    return "" if message.reason in _ORDINARY else of_topic(topic, message.reason_text)
