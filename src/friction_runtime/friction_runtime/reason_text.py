"""Texts of the reasons in messages: each names its wheel once."""


def of_wheel(wheel: str, text: str) -> str:
    """Text that names a wheel; as it is where it is empty, or begins with the wheel or one of its topics."""
    if not text or text.startswith((f"{wheel}: ", f"{wheel}/")):
        return text
    return f"{wheel}: {text}"


def without_wheel(wheel: str, text: str) -> str:
    """Text without the name of the wheel, for a place that names it."""
    return text.removeprefix(f"{wheel}: ")


def of_topic(topic: str, text: str) -> str:
    """Text that another node gave on a topic of a wheel; the topic names the wheel."""
    wheel, _, _ = topic.partition("/")
    return f"{topic}: {without_wheel(wheel, text)}"
