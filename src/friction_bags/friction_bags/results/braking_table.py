"""The table that ends a command: each braking with its grip, mu_max and lambda_max; also as JSON and CSV."""

from __future__ import annotations

import csv
import json
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from friction_bags.bag_io.bag_format import BagError
from friction_bags.results.braking_rows import BrakingRow, Part, braking_rows
from friction_bags.results.recorded_run import COLUMNS
from friction_bags.results.run_reader import read_run
from friction_runtime.reports import INTERVAL_95

_VALID = "validity.valid"
_NEEDED = {
    "friction_msgs/msg/WheelSlip": ("slip", "vehicle_speed", _VALID),
    "friction_msgs/msg/FrictionCurve": ("lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev", _VALID),
    **{kind: COLUMNS[kind] for kind in ("friction_msgs/msg/Grip", "geometry_msgs/msg/TwistWithCovarianceStamped")},
}
_NONE = "No braking: the vehicle speed is not known, or never falls by 1 m/s with more than 1 m/s²."
_BRAKING = (
    *("start", "end", "from_speed", "to_speed", "mean_deceleration", "largest_deceleration"),
    *("largest_slip", "slip_of"),
)
_MOST_STARTS = 5
QUANTITIES = ("mu_used", "mu_max", "lambda_max")


def add_table_arguments(parser: ArgumentParser) -> None:
    """Declare the options that write the table to files."""
    for kind in ("json", "csv"):
        parser.add_argument(
            f"--{kind}", type=Path, metavar="FILE", help=f"write the table of brakings as {kind.upper()}"
        )


def rows_of_bag(bag: Path, prefix: str, progress: Callable[[float], None]) -> list[BrakingRow]:
    """Read the brakings of a bag; none where it holds nothing to find them by.

    Args:
        bag: directory of the bag.
        prefix: namespace of the topics, with a slash at either end.
        progress: called with the share that has been read, 0 to 1.
    """
    try:
        return braking_rows(read_run(bag, None, prefix, progress, _NEEDED))
    except BagError:
        return []


def show_brakings(options: Namespace, brakings: Mapping[str, Sequence[BrakingRow]], console: Console) -> None:
    """Print the table of each bag, and write the files of the options.

    Args:
        options: of a command line with add_table_arguments.
        brakings: rows by the name of their bag.
        console: where it is printed.

    Raises:
        OSError: a file cannot be written.
    """
    for name, rows in brakings.items():
        print_brakings(console, name, rows)
    if options.json is not None:
        listed = [
            {"bag": name, **_braking(row), "of": [_part(part) for part in row.parts]}
            for name, rows in brakings.items()
            for row in rows
        ]
        options.json.write_text(json.dumps({"brakings": listed}, indent=1) + "\n", encoding="utf-8")
    if options.csv is not None:
        with options.csv.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["bag", *_BRAKING, *_part(Part(""))])
            for name, rows in brakings.items():
                for row in rows:
                    writer.writerows([name, *_braking(row).values(), *_part(part).values()] for part in row.parts)


def print_brakings(console: Console, name: str, rows: Sequence[BrakingRow]) -> None:
    """Print a table of brakings; at 80 columns no number is cut."""
    if not rows:
        console.print(_NONE, soft_wrap=True)
        return
    title = escape(f"Brakings of {name}, with 95 % intervals")
    table = Table(title=title, title_justify="left", box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("time [s]", "v [m/s]", "a [m/s²]", "of", "grip used", "µ_max", "λ_max", "valid"):
        table.add_column(escape(heading), no_wrap=heading != "of")
    reasons: dict[str, list[str]] = {}
    for row in rows:
        begin = (
            f"{row.start:.1f}–{row.end:.1f}",
            f"{round(row.from_speed)}–{round(row.to_speed)}",
            f"{row.mean_deceleration:.1f}/{row.largest_deceleration:.1f}",
        )
        for part in row.parts:
            valid = f"{part.valid:.0%}" if isfinite(part.valid) else ""
            table.add_row(*begin, escape(part.of), *(with_interval(part, each) for each in QUANTITIES), valid)
            if isfinite(part.true_mu_max):
                table.add_row("", "", "", "true", "", f"{part.true_mu_max:.3f}", f"{part.true_lambda_max:.3f}", "")
            begin = ("", "", "")
            if part.reason:
                reasons.setdefault(f"{part.of}: no valid curve: {part.reason}", []).append(f"{row.start:.1f}")
    console.print(table)
    console.print("a: deceleration, mean/largest; µ_max, λ_max: most certain; valid: share of time", highlight=False)
    for reason, starts in reasons.items():
        when = f"{', '.join(starts[:_MOST_STARTS])}{', …' if len(starts) > _MOST_STARTS else ''} s"
        console.print(escape(f"{when}, {reason}"), soft_wrap=True, highlight=False)


def with_interval(part: Part, quantity: str) -> str:
    """Return one of QUANTITIES with half of its 95 % interval; a dash where no curve was valid."""
    value, stddev = getattr(part, quantity), getattr(part, f"{quantity}_stddev")
    if not isfinite(value):
        return "–" if part.reason and quantity != "mu_used" else ""
    digits = 2 if quantity == "mu_used" else 3
    return f"{value:.{digits}f}±{INTERVAL_95 * stddev:.{digits}f}" if isfinite(stddev) else f"{value:.{digits}f}±?"


def _braking(row: BrakingRow) -> dict[str, Any]:
    return {name: _known(getattr(row, name)) for name in _BRAKING}


def _part(part: Part) -> dict[str, Any]:
    """Return a part for files: 95 % intervals in place of deviations, None for what is not known."""
    made: dict[str, Any] = {"of": part.of}
    for name in QUANTITIES:
        value, reach = getattr(part, name), INTERVAL_95 * getattr(part, f"{name}_stddev")
        made |= {name: _known(value), f"{name}_lower": _known(value - reach), f"{name}_upper": _known(value + reach)}
    others = ("valid", "valid_at", "reason", "true_mu_max", "true_lambda_max")
    return made | {name: _known(getattr(part, name)) for name in others}


def _known(value: float | str) -> float | str | None:
    return value if isinstance(value, str) or isfinite(value) else None
