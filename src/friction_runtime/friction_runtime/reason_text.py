"""Validity of an estimate in messages: valid, reason, and a text that names its wheel once."""

from typing import Any


def set_reason(message: Any, wheel: str, reason: int, text: str) -> None:
    """Set what every message of an estimate has: `valid`, `reason` and `reason_text`.

    Args:
        message: with these fields.
        wheel: it is of.
        reason: enum with the values of the message; 0 is OK in all of them.
        text: the reason in words, empty where it is OK.
    """
    message.valid = reason == 0
    message.reason = int(reason)
    message.reason_text = of_wheel(wheel, text)


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
