"""What a check says: a number with its deviation, a verdict, a sentence, and what to change."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import nan


class Verdict(Enum):
    """How a finding is to be taken."""

    OK = "OK"
    NOTE = "-"
    """It cannot be told from this drive; that is no trouble."""
    WARN = "WARN"
    """Estimates get worse by it."""
    FAIL = "FAIL"
    """Estimates are wrong with it."""


@dataclass(frozen=True)
class Finding:
    """One line of the report."""

    check: str
    """Name of the check, such as `radius`."""
    subject: str
    """Topic, wheel or quantity."""
    verdict: Verdict
    sentence: str
    value: float = nan
    """In `unit`; NaN where there is no number."""
    stddev: float = nan
    """One standard deviation of the value, everything included that is known to be in it."""
    unit: str = ""
    remedy: str = ""
    """What to change; empty where nothing is to be."""
    learned: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Values for the vehicle file with their deviations, by dotted key, such as `wheels.FL.radius`."""


def failure(check: str, subject: str, sentence: str, remedy: str) -> Finding:
    """Return a FAIL that has no number."""
    return Finding(check, subject, Verdict.FAIL, sentence, remedy=remedy)


def against_file(value: float, stddev: float, stated: float, stated_stddev: float | None, least: float) -> Verdict:
    """Compare a learned value with that of the vehicle file.

    Args:
        value: learned.
        stddev: its deviation.
        stated: in the file.
        stated_stddev: the deviation that the file states; None: none.
        least: difference that does no harm, in the unit of the value.

    Returns:
        WARN where they differ by more than three deviations and by more than `least`.
    """
    doubt = (stddev**2 + (stated_stddev or 0.0) ** 2) ** 0.5
    return Verdict.WARN if abs(value - stated) > max(3.0 * doubt, least) else Verdict.OK
