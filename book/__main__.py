"""Command line: `python3 -m book [--section 8.3] [--out DIRECTORY] [--effort RATIO] [--json FILE]`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from benchmarks.runner import load_part, run_part
from friction_parameters.command_line import command

_TITLE = "Numbers of the chapter beside ours"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; return the exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return command(lambda: run_part("python3 -m book", _TITLE, load_part("book", "report"), given))


if __name__ == "__main__":
    sys.exit(main())
