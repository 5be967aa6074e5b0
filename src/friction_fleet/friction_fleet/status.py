"""`status`: how far the processing of a fleet is, from the tables alone."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from friction_fleet.dataset import DAMAGED, FAILED, OK, Dataset

_MOST_SHOWN = 20


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("dataset", metavar="URL", help="directory of the tables")


def run(options: Namespace) -> int:
    """Print counts, the bags that failed with their reasons, and what processing costs.

    Returns:
        Exit code: 0, 1 where a bag failed.
    """
    rows = Dataset(options.dataset).bags()
    console = Console()
    counts = Counter(row["status"] for row in rows)
    console.print(f"{len(rows)} bags: {', '.join(f'{number} {status}' for status, number in sorted(counts.items()))}")
    done = [row for row in rows if row["status"] in (OK, DAMAGED)]
    if done:
        hours = sum(row["duration"] for row in done) / 3600.0
        cpu = sum(row["cpu_seconds"] for row in done) / 3600.0
        first, last = (side(row["start"] for row in done) for side in (min, max))
        console.print(
            f"{hours:.2f} h of {len({row['vehicle'] for row in done})} cars, {first:%Y-%m-%d} to {last:%Y-%m-%d}"
        )
        console.print(
            f"{sum(row['brakings'] for row in done)} brakings, {sum(row['fits'] for row in done)} with a peak"
        )
        console.print(f"{cpu / hours:.3f} core-hours an hour, at most {max(row['memory_mb'] for row in done):.0f} MB")
        versions = {row["settings"] for row in done}
        if len(versions) > 1:
            console.print(f"results of {len(versions)} settings or versions: `process` again makes them one")
    failed = [row for row in rows if row["status"] in FAILED]
    if failed:
        table = Table("failed", "error", box=None)
        for row in failed[:_MOST_SHOWN]:
            table.add_row(escape(row["path"]), escape(row["error"]))
        console.print(table)
    return int(bool(failed))
