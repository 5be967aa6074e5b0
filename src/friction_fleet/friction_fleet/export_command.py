"""`export`: writes a map as signals of the COVESA vehicle signal specification."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path

from friction_fleet.export import read_parquet, vss


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("map", type=Path, metavar="MAP.parquet", help="as `map` has written it")
    parser.add_argument("--vss", type=Path, required=True, metavar="FILE", help="JSON lines, one a cell")


def run(options: Namespace) -> int:
    """Write the file; return 0.

    Raises:
        OSError: a file cannot be read or written.
    """
    lines = [json.dumps(each) for each in vss(*read_parquet(options.map))]
    options.vss.write_text("\n".join([*lines, ""]), encoding="utf-8")
    print(f"{options.vss}: {len(lines)} cells")
    return 0
