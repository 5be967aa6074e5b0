"""Texts of the reasons in messages: each names its wheel once."""


def of_wheel(wheel: str, text: str) -> str:
    """Return a text that names the wheel; unchanged where it is empty or begins with the wheel or one of its topics."""
    if not text or text.startswith((f"{wheel}: ", f"{wheel}/")):
        return text
    return f"{wheel}: {text}"


def without_wheel(wheel: str, text: str) -> str:
    """Return a text without the name of the wheel, for a place that already names it."""
    return text.removeprefix(f"{wheel}: ")


def of_topic(topic: str, text: str) -> str:
    """Return a text received from another node on a topic of a wheel; the topic names the wheel."""
    wheel, _, _ = topic.partition("/")
    return f"{topic}: {without_wheel(wheel, text)}"
