"""Kinds of reports: two reports are of one kind if they differ only in values from a message."""

import re
from math import inf

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
