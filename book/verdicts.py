"""Statements of the chapter beside the results of this run.

A verdict is never written by hand where there are numbers: it follows from the chapter's number, ours and a rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from benchmarks.rows import Row, as_text


class Judgement(Enum):
    """Of a statement."""

    AGREES = "agrees"
    DIFFERS = "differs"
    NOT_PUBLIC = "not public"


@dataclass(frozen=True)
class Verdict:
    """A statement or number of the chapter beside ours."""

    place: str
    """Section, figure, table or equation."""
    statement: str
    """In our words."""
    chapter: str
    """Its number, or what it claims."""
    ours: str
    judgement: Judgement
    because: str = ""
    """Why it differs or cannot be judged; empty where it agrees."""

    def __post_init__(self) -> None:
        """Refuse a verdict that leaves a question open.

        Raises:
            ValueError: place, statement or our result is empty, or the reason is, where the judgement needs one.
        """
        if not (self.place and self.statement and self.ours):
            raise ValueError(f"a verdict needs place, statement and our result: {self}")
        if (self.judgement is Judgement.AGREES) == bool(self.because):
            raise ValueError(f"a reason belongs to a verdict that is not '{Judgement.AGREES.value}': {self}")


class Spread(NamedTuple):
    """Middle 90 % of our runs, and their median; NaN where no run gave a number."""

    low: float
    median: float
    high: float


def single_run(place: str, statement: str, chapter: Sequence[float], ours: Sequence[Spread], because: str) -> Verdict:
    """Judge numbers of single runs [%]: each must lie among the middle 90 % of our runs.

    Args:
        place: in the chapter.
        statement: what the numbers are.
        chapter: its numbers.
        ours: for each of them our runs.
        because: the reason, should one lie outside.
    """
    inside = all(runs.low <= number <= runs.high for number, runs in zip(chapter, ours, strict=True))
    texts = (f"{as_text(runs.median)} ({as_text(runs.low)} to {as_text(runs.high)})" for runs in ours)
    numbers = "; ".join(as_text(float(value)) for value in chapter)
    return _judged(place, statement, numbers, "; ".join(texts), inside, because)


def close(place: str, statement: str, chapter: float, ours: float, within: float, because: str) -> Verdict:
    """Judge a number: ours must be `within` this share of the chapter's."""
    agrees = abs(ours - chapter) <= within * abs(chapter)
    return _judged(place, statement, as_text(chapter), as_text(ours), agrees, because)


def claim(place: str, statement: str, holds: bool, ours: str, because: str) -> Verdict:
    """Judge a statement without a number by whether our numbers, named in `ours`, bear it out."""
    return _judged(place, statement, "", ours, bool(holds), because)


def not_public(place: str, statement: str, because: str) -> Verdict:
    """Leave open what the chapter's data alone could show."""
    return Verdict(place, statement, "", "–", Judgement.NOT_PUBLIC, because)


def rows(verdicts: Sequence[Verdict]) -> list[Row]:
    """Return the verdicts as flat rows."""
    return [
        {
            "place": v.place,
            "statement": v.statement,
            "chapter": v.chapter,
            "ours": v.ours,
            "verdict": v.judgement.value,
            "because": v.because,
        }
        for v in verdicts
    ]


def counts(verdicts: Sequence[Verdict]) -> str:
    """Return how many statements there are of each judgement, in words."""
    words = {Judgement.AGREES: "agree", Judgement.DIFFERS: "differ", Judgement.NOT_PUBLIC: "not public"}
    return ", ".join(f"{sum(v.judgement is j for v in verdicts)} {word}" for j, word in words.items())


def _judged(place: str, statement: str, chapter: str, ours: str, agrees: bool, because: str) -> Verdict:
    judgement = Judgement.AGREES if agrees else Judgement.DIFFERS
    return Verdict(place, statement, chapter, ours, judgement, "" if agrees else because)
