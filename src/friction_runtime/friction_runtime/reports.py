"""Texts of reports and reasons: the name of the wheel once, and reports of one kind at a limited rate."""

import re
from math import inf

INTERVAL_95 = 1.96
"""Half width of a 95 % interval [standard deviations]: all tables and plots show this one."""


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


_RAW = re.compile(
    r"""
    "[^"]*"                                               # a string from a message
    | (?<![\w.']) [-+]? (?: \d+ (?: \.\d+ )? (?: e[-+]?\d+ )? | nan | inf ) (?! \w | \.\d )   # a number, not of a name
    """,
    re.VERBOSE,
)
REPEAT_AFTER = 5.0
"""Time between two reports of one kind [s]."""
_MOST_KINDS = 1000


def report_kind(text: str) -> str:
    """Return a text without its numbers and without what stands in double quotes; digits in names remain."""
    return _RAW.sub("#", text)


class ReportLimit:
    """Lets one report of a kind pass every few seconds: garbage at 200 Hz must not fill the log."""

    def __init__(self) -> None:
        """Start without any report."""
        self._said: dict[str, float] = {}

    def passes(self, text: str, now: float) -> bool:
        """Whether a report at the time `now` [s] should be logged."""
        kind = report_kind(text)
        if now - self._said.get(kind, -inf) < REPEAT_AFTER:
            return False
        if len(self._said) >= _MOST_KINDS:
            self._said.clear()
        self._said[kind] = now
        return True
