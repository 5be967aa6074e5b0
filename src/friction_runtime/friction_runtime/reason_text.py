"""Validity of an estimate in its message, with a text that names its wheel once."""

from typing import Any

from friction_msgs.msg import Validity

from vehicle_models.reason import Reason


def validity(wheel: str, reason: Reason, text: str) -> Any:
    """Return a message Validity.

    Args:
        wheel: name of the wheel that the estimate is of.
        reason: why it may not be used.
        text: the reason in words, empty where it is OK.
    """
    message = Validity()
    message.valid = reason == Reason.OK
    message.reason = int(reason)
    message.text = of_wheel(wheel, text)
    return message


def of_wheel(wheel: str, text: str) -> str:
    """Return a text that names the wheel; unchanged where it is empty or begins with the wheel or one of its topics."""
    if not text or (text.startswith(wheel) and text.startswith((f"{wheel}: ", f"{wheel}/"))):
        return text
    return f"{wheel}: {text}"


def without_wheel(wheel: str, text: str) -> str:
    """Return a text without the name of the wheel, for a place that already names it."""
    return text.removeprefix(f"{wheel}: ")


def plain_reason(text: str, of: str) -> str:
    """Return a reason without the name of the wheel that it speaks of."""
    return text.removeprefix(f"{of}: ").removeprefix(f"{of}/")


def of_topic(topic: str, text: str) -> str:
    """Return a text received from another node on a topic of a wheel; the topic names the wheel."""
    wheel, _, _ = topic.partition("/")
    return f"{topic}: {without_wheel(wheel, text)}"
