"""What the chapter states, each beside what this run found: agrees, differs because, or not public.

A verdict is never written by hand where there are numbers: it follows from the chapter's number, ours and a rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from friction_evaluation.rows import Row, as_text

_RUNS = (5.0, 95.0)
"""Percentiles of our runs between which a number of a single run may lie."""


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


def single_run(
    place: str, statement: str, chapter: Sequence[float], ours: Sequence[ArrayLike], because: str
) -> Verdict:
    """Judge numbers of single runs [%]: each must lie among the middle 90 % of our runs.

    Args:
        place: in the chapter.
        statement: what the numbers are.
        chapter: its numbers.
        ours: for each of them our runs, shape (runs,); NaN is a run that gave none.
        because: the reason, should one lie outside.
    """
    texts, inside = [], True
    for number, runs in zip(chapter, ours, strict=True):
        known = np.asarray(runs, dtype=np.float64)
        known = known[np.isfinite(known)]
        if not known.size:
            return _judged(place, statement, _numbers(chapter), "no run gave one", False, because)
        low, high = np.percentile(known, _RUNS)
        inside &= bool(low <= number <= high)
        texts.append(f"{as_text(float(np.median(known)))} ({as_text(float(low))} to {as_text(float(high))})")
    return _judged(place, statement, _numbers(chapter), "; ".join(texts), inside, because)


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
    return ", ".join(f"{sum(v.judgement is j for v in verdicts)} {j.value}" for j in Judgement)


def _judged(place: str, statement: str, chapter: str, ours: str, agrees: bool, because: str) -> Verdict:
    judgement = Judgement.AGREES if agrees else Judgement.DIFFERS
    return Verdict(place, statement, chapter, ours, judgement, "" if agrees else because)


def _numbers(values: Sequence[float]) -> str:
    return "; ".join(as_text(float(value)) for value in values)
