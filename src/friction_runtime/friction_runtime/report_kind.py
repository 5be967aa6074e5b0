"""Kinds of reports: of one kind are those that differ only in what a message held."""

import re
from math import inf

_RAW = re.compile(
    r"""
    "[^"]*"                                               # a string from a message
    | (?<![\w.']) [-+]? (?: \d+ (?: \.\d+ )? (?: e[-+]?\d+ )? | nan | inf ) (?! \w | \.\d )   # a number, not of a name
    """,
    re.VERBOSE,
)
_REPEAT_AFTER = 5.0
"""[s]"""
_MOST_KINDS = 1000


def report_kind(text: str) -> str:
    """Text without its numbers and without what stands in double quotes; digits of names remain."""
    return _RAW.sub("#", text)


class ReportLimit:
    """Lets one report of a kind pass every few seconds: garbage at 200 Hz must not fill the log."""

    def __init__(self) -> None:
        """Start with nothing said."""
        self._said: dict[str, float] = {}

    def passes(self, text: str, now: float) -> bool:
        """Tell whether a report at the time `now` [s] is to be said."""
        kind = report_kind(text)
        if now - self._said.get(kind, -inf) < _REPEAT_AFTER:
            return False
        if len(self._said) >= _MOST_KINDS:
            self._said.clear()
        self._said[kind] = now
        return True
