"""Headline numbers of README.md: each repeated by its command, and compared with the committed number.

`headlines.yaml` holds the numbers. Each has a noise, by which a run on another machine may differ; a number that
today's code misses by more fails. `--table` prints the rows of README.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from benchmarks.runner import Row, at_most, rows_of

FILE = Path(__file__).with_name("headlines.yaml")


@dataclass(frozen=True)
class Number:
    """A number of a headline: the value of a column in the row that `where` selects."""

    label: str
    where: dict[str, Any]
    column: str
    value: float
    noise: float
    quick_noise: float | None = None
    """Of the quick command, where there is one."""


@dataclass(frozen=True)
class Headline:
    """A row of the table of results in README.md."""

    name: str
    command: str
    """Part of benchmarks with its options."""
    numbers: list[Number]
    quick: str = ""
    """Command that takes seconds: fewer seeds."""
    unit: str = ""
    where: dict[str, Any] = field(default_factory=dict)
    """Of all of its numbers."""

    def line(self) -> str:
        """Return the row of README.md."""
        numbers = ", ".join(f"{each.label} {each.value}" for each in self.numbers) + (
            f" {self.unit}" if self.unit else ""
        )
        return f"| `python3 -m benchmarks {self.command}` | {self.name} | {numbers} |"


def load() -> list[Headline]:
    """Read the committed numbers."""
    read = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    return [Headline(**each | {"numbers": [Number(**number) for number in each["numbers"]]}) for each in read]


def compared(headline: Headline, rows: Sequence[Row], quick: bool = False) -> Iterator[Row]:
    """Yield a row for each number: by how much today's rows miss it, and its noise as the limit.

    Raises:
        ValueError: not one row is the number's.
    """
    for number in headline.numbers:
        wanted = headline.where | number.where
        found = [row for row in rows if number.column in row and wanted.items() <= row.items()]
        if len(found) != 1:
            raise ValueError(f"{headline.name}, {number.label}: {len(found)} rows with {wanted} and {number.column}")
        today = float(found[0][number.column])
        noise = number.quick_noise if quick and number.quick_noise is not None else number.noise
        yield {
            "headline": headline.name,
            "number": number.label,
            "committed": number.value,
            "today": today,
            "quantity": "missed by",
            **at_most(abs(today - number.value), noise),
        }


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--quick", action="store_true", help="only those with a command of a few seconds, by it")
    parser.add_argument("--table", action="store_true", help="only print the rows of README.md")


def run(options: argparse.Namespace) -> list[Row]:
    """Repeat every headline."""
    headlines = load()
    if options.table:
        print(*(headline.line() for headline in headlines), sep="\n")
        return []
    rows: list[Row] = []
    for headline in headlines:
        command = headline.quick if options.quick else headline.command
        if command:
            rows += compared(headline, rows_of("benchmarks", *command.split()), options.quick)
    return rows
