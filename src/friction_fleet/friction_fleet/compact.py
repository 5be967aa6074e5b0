"""`compact`: deletes the files of results that are no longer those of any bag."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from friction_fleet.dataset import Dataset


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("dataset", metavar="URL", help="directory of the tables; nothing may write to it meanwhile")


def run(options: Namespace) -> int:
    """Delete them; return 0."""
    print(f"{Dataset(options.dataset).compact()} files deleted")
    return 0
