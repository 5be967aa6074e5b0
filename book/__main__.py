"""Command line: `python3 -m book [--out DIRECTORY] [--effort SHARE] [--json FILE]`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from benchmarks.command import load_part, run_part
from friction_parameters.command_line import command


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; return the exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    title = "every table and figure of the chapter beside its own numbers, as one page"
    return command(lambda: run_part("python3 -m book", title, load_part("book.part"), given))


if __name__ == "__main__":
    sys.exit(main())
