"""Findings as a table and as JSON."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from vehicle_doctor.finding import Finding, Verdict

_STYLES = {Verdict.OK: "green", Verdict.NOTE: "dim", Verdict.WARN: "yellow", Verdict.FAIL: "bold red"}


def print_findings(title: str, findings: Sequence[Finding]) -> None:
    """Print the table and, last, what there is to do."""
    table = Table(title=escape(title))
    for heading in ("", "check", "of", "value", "", "what to change"):
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
    doubt = f" ± {finding.stddev:.2g}" if isfinite(finding.stddev) else ""
    return f"{finding.value:.4g}{doubt} {finding.unit}".rstrip()
