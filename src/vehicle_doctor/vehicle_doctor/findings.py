"""Findings of the checks, printed as a table or written as JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import isfinite, nan
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from friction_runtime.reports import INTERVAL_95


class Verdict(Enum):
    """How a finding is to be taken."""

    OK = "OK"
    NOTE = "-"
    """Not determined by this drive; no fault."""
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


def against_file(value: float, stddev: float, in_file: float, file_stddev: float | None, least: float) -> Verdict:
    """Compare a learned value with that of the vehicle file.

    Args:
        value: learned.
        stddev: its deviation.
        in_file: in the file.
        file_stddev: the deviation that the file states; None: none.
        least: difference that does no harm, in the unit of the value.

    Returns:
        WARN where they differ by more than three deviations and by more than `least`.
    """
    uncertainty = (stddev**2 + (file_stddev or 0.0) ** 2) ** 0.5
    return Verdict.WARN if abs(value - in_file) > max(3.0 * uncertainty, least) else Verdict.OK


_STYLES = {Verdict.OK: "green", Verdict.NOTE: "dim", Verdict.WARN: "yellow", Verdict.FAIL: "bold red"}


def print_findings(title: str, findings: Sequence[Finding]) -> None:
    """Print the table and, last, what there is to do."""
    table = Table(title=escape(title))
    for heading in ("", "check", "of", "value ± 95 %", "", "what to change"):
        table.add_column(heading, overflow="fold")
    for each in findings:
        verdict = f"[{_STYLES[each.verdict]}]{each.verdict.value}[/]"
        texts = (each.check, each.subject, _number(each), each.sentence, each.remedy)
        table.add_row(verdict, *map(escape, texts))
    # wide enough that no column is cut where the output goes to a file
    console = Console()
    (console if console.is_terminal else Console(width=200)).print(table)
    counts = {verdict: sum(each.verdict is verdict for each in findings) for verdict in (Verdict.FAIL, Verdict.WARN)}
    print(", ".join(f"{count} {verdict.value}" for verdict, count in counts.items()))


def as_json(findings: Sequence[Finding]) -> dict[str, Any]:
    """Return the findings as JSON takes them; a number that is not there is null."""
    return {
        "findings": [
            {
                "check": each.check,
                "subject": each.subject,
                "verdict": each.verdict.name,
                "value": _known(each.value),
                "stddev": _known(each.stddev),
                "unit": each.unit,
                "sentence": each.sentence,
                "remedy": each.remedy,
                "learned": {key: {"value": pair[0], "stddev": pair[1]} for key, pair in each.learned.items()},
            }
            for each in findings
        ]
    }


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


def _number(finding: Finding) -> str:
    if not isfinite(finding.value):
        return ""
    uncertainty = f" ± {INTERVAL_95 * finding.stddev:.2g}" if isfinite(finding.stddev) else ""
    return f"{finding.value:.4g}{uncertainty} {finding.unit}".rstrip()
