"""Command line: `python3 -m vehicle_doctor BAG` examines the signals of a drive and learns the car from it."""

import sys
from collections.abc import Sequence
from importlib import import_module

from friction_parameters.command_line import command


def main(arguments: Sequence[str] | None = None) -> int:
    """Examine a drive; return the exit code: 0, 1 for a WARN or FAIL, 2 for bad input."""
    return command(lambda: int(import_module("vehicle_doctor.command").run(arguments)))


if __name__ == "__main__":
    sys.exit(main())
