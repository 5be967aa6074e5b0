"""Command line: `python3 -m friction_report BAG --out PAGE.html` writes a drive as one page for a browser."""

import sys
from collections.abc import Sequence
from importlib import import_module

from friction_parameters.command_line import command


def main(arguments: Sequence[str] | None = None) -> int:
    """Write a page; return the exit code: 0, 1 when the bag is damaged, 2 for bad input."""
    return command(lambda: int(import_module("friction_report.command").run(arguments)))


if __name__ == "__main__":
    sys.exit(main())
