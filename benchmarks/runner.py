"""Runner of all studies: flat rows with limits, the command line.

A study is a module with `add_arguments(parser)` and `run(options) -> rows`. A row with a limit has `value`, `limit` and
`passed`; where `passed` is None or absent, the row is for information. The exit code is 1 where a row fails.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from math import isfinite, isnan
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from benchmarks.engine import ENGINE, add_engine_arguments, engine_of
from friction_parameters.command_line import command
from friction_runtime.blas_threads import use_one_blas_thread

Row = dict[str, Any]
"""Names and numbers or texts."""


def columns(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, in the order in which they first appear; every row may have its own."""
    return list(dict.fromkeys(name for row in rows for name in row))


def as_text(value: Any) -> str:
    """Four significant digits of a float, a dash for NaN, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, float):
        return "–" if isnan(value) else f"{value:.4g}"
    return str(value)


def at_most(value: float, limit: float) -> Row:
    """Columns of a row whose value may not be above the limit; NaN does not pass."""
    return {"value": value, "limit": limit, "passed": bool(value <= limit)}


def at_least(value: float, limit: float) -> Row:
    """Columns of a row whose value may not be below the limit; NaN does not pass."""
    return {"value": value, "limit": limit, "passed": bool(value >= limit)}


def not_judged(value: float) -> Row:
    """Columns of a row for information among rows that have a limit."""
    return {"value": value, "limit": None, "passed": None}


def failures(rows: Sequence[Row]) -> list[Row]:
    """Return the rows that do not hold."""
    return [row for row in rows if row.get("passed") not in (None, True)]


def plain(row: Row) -> Row:
    """JSON has no NaN and no infinity: they become null and the text "inf"."""
    found: Row = {}
    for name, value in row.items():
        if hasattr(value, "item"):
            value = value.item()
        if isinstance(value, float) and not isfinite(value):
            value = None if isnan(value) else ("inf" if value > 0 else "-inf")
        found[name] = value
    return found


def run_lengths(true: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lengths of all runs of true values down each column of an array of shape (n, wheels)."""
    padded = np.pad(true, ((1, 1), (0, 0))).astype(np.int8).T
    edges = np.diff(padded, axis=1).ravel()
    return np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)


class Part(Protocol):
    """Module of a study."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add its own options."""

    def run(self, options: argparse.Namespace) -> Sequence[Row]:
        """Do it, with a progress bar, and return flat rows; what has to hold is in their `passed` (rows.py)."""


def load_part(program: str, name: str) -> Part:
    """Import a part when it is needed: some need the middleware, some only numpy."""
    is_package = (Path(__file__).parents[1] / program / name).is_dir()
    return cast(Part, import_module(f"{program}.{name}.part" if is_package else f"{program}.{name}"))


@cache
def rows_of(program: str, name: str, *arguments: str) -> Sequence[Row]:
    """Run a part with the arguments of its command line; the same ones are run once."""
    part = load_part(program, name)
    parser = argparse.ArgumentParser(prog=name)
    part.add_arguments(parser)
    return part.run(parser.parse_args(arguments))


def main_of(program: str, parts: Mapping[str, str], arguments: Sequence[str] | None) -> int:
    """Run one of several parts by its name.

    Args:
        program: name of the package.
        parts: names and one-line descriptions.
        arguments: the command line, None for that of the process.

    Returns:
        Exit code: 1 where a row fails, 2 where a parameter or a file is bad, else 0.
    """

    def run() -> int:
        given = list(sys.argv[1:] if arguments is None else arguments)
        parser = argparse.ArgumentParser(prog=f"python3 -m {program}")
        parser.add_argument("part", choices=parts, help="; ".join(f"{name}: {text}" for name, text in parts.items()))
        name = parser.parse_args(given[:1]).part
        return run_part(f"python3 -m {program} {name}", parts[name], load_part(program, name), given[1:])

    return command(run)


def run_part(program: str, title: str, part: Part, arguments: Sequence[str]) -> int:
    """Run a part, print its table and write its rows; return 1 where a row fails, else 0."""
    use_one_blas_thread()  # importing it does so; algorithms alone do not import it
    parser = argparse.ArgumentParser(prog=program, description=title)
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    add_engine_arguments(parser)
    part.add_arguments(parser)
    options = parser.parse_args(arguments)
    ENGINE.set(engine_of(options))
    rows = list(part.run(options))
    print_rows(title, rows)
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"rows": [plain(row) for row in rows]}, indent=1)
        options.json.write_text(text + "\n", encoding="utf-8")
    failed = failures(rows)
    for row in failed:
        print(f"failed: {', '.join(f'{name} {as_text(value)}' for name, value in row.items())}", file=sys.stderr)
    return int(bool(failed))


def print_rows(title: str, rows: Sequence[Row]) -> None:
    """Print flat rows as a table; every row may have its own columns."""
    names = columns(rows)
    table = Table(title=title)
    for name in names:
        table.add_column(escape(name), overflow="fold")
    for row in rows:
        table.add_row(*(escape(as_text(row.get(name, ""))) for name in names))
    # Wide enough that no column is cut where the output goes to a file.
    console = Console()
    (console if console.is_terminal else Console(width=240)).print(table)
