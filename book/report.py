"""The report: every table and every figure with data of the chapter beside its own numbers.

Writes `index.html` (one file, opens offline) and `results.json` (every row, by section).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from benchmarks.runner import Row, plain
from book import identification, slope, smart_tyre, speed
from book.page import SYMBOLS, Section, page
from friction_parameters.command_line import positive
from friction_parameters.parameter import ParameterError

TITLE = "Tyre-road friction: chapter 8, reproduced"
_INTRODUCTION = """All numbers and pictures are made by this code with fixed seeds, through the shipped estimators and
their shipped parameters. The chapter's test drives are not public; simulated stops with its lambda_max and its noise
stand for them."""
SECTIONS: dict[str, Callable[[Path, Callable[[int], int]], Section]] = {
    "8.2": slope.section,
    "8.3.2": identification.section,
    "8.3.3": speed.section,
    "8.4": smart_tyre.section,
}
"""By the chapter's numbers; each makes its runs and draws into a directory."""
_FEWEST = 2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--section", default="8", help=f"only this one, of {', '.join(SECTIONS)}; 8.3 is both of 8.3")
    parser.add_argument("--out", type=Path, default=Path("build/report"), help="directory (default: build/report)")
    parser.add_argument("--effort", type=positive, default=1.0, help="ratio of the seeds of the full evaluation")


def run(options: argparse.Namespace) -> list[Row]:
    """Write the report; return what it holds."""
    chosen = [make for number, make in SECTIONS.items() if f"{number}.".startswith(f"{options.section}.")]
    if not chosen:
        raise ParameterError(f"--section {options.section}: the sections are {', '.join(SECTIONS)}")
    pictures = options.out / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    console = Console()
    made: list[Section] = []
    for make in chosen:
        made.append(make(pictures, lambda full: max(_FEWEST, round(options.effort * full))))
        _write(options.out, made)  # after each section: a run that is ended early leaves what it has made
        console.print(f"{made[-1].title}: done")
    console.print(f"report {options.out / 'index.html'}", soft_wrap=True)
    return [row for section in made for row in section.numbers]


def _write(out: Path, made: Sequence[Section]) -> None:
    (out / "index.html").write_text(page(TITLE, _INTRODUCTION, made, SYMBOLS), encoding="utf-8")
    results: dict[str, object] = {"numbers": [plain(row) for section in made for row in section.numbers]}
    results |= {s.key: {table.caption: [plain(row) for row in table.rows] for table in s.tables} for s in made}
    (out / "results.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
