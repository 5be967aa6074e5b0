"""`import`: makes a bag of our input topics from measured data in a CSV file."""

import csv
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from pathlib import Path

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.message_bag import write_bag
from friction_bags.importers import bmw, iac

_FORMATS = {"bmw": bmw, "iac": iac}


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("format", choices=sorted(_FORMATS), help="format of the columns in the file")
    parser.add_argument("csv", type=Path, help="file of measured data")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="bag to write")


def run(args: Namespace) -> int:
    """Import a file.

    Returns:
        Exit code: 0.

    Raises:
        BagError: the file cannot be read or the bag cannot be made.
        OSError: a file cannot be read or written.
    """
    module = _FORMATS[args.format]
    count = write_bag(args.out, module.messages(read_rows(args.csv, module.COLUMNS)), module.NOTES)
    print(f"{args.out}: {count} messages from {args.csv}")
    return 0


def read_rows(path: Path, columns: Iterable[str]) -> Iterator[dict[str, float]]:
    """Yield the rows of a CSV file as numbers by column.

    Args:
        path: path of the file; its first line names the columns.
        columns: columns to read; others are left out.

    Raises:
        BagError: a column is missing or a value is not a number; the text names it.
        OSError: the file cannot be read.
    """
    wanted = list(columns)
    with path.open(newline="", encoding="utf-8") as stream:
        reader = csv.DictReader(stream)
        missing = [column for column in wanted if column not in (reader.fieldnames or [])]
        if missing:
            raise BagError(f"{path} has no column {', '.join(missing)}")
        for row in reader:
            try:
                yield {column: float(row[column]) for column in wanted}
            except (TypeError, ValueError):
                raise BagError(f"{path}, line {reader.line_num}: a value is not a number") from None
