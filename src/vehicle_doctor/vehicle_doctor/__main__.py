"""Command line: `python3 -m vehicle_doctor BAG` examines the signals of a drive and learns the car from it."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from importlib import import_module

from friction_parameters.command_line import command, split_ros_arguments


def main(arguments: Sequence[str] | None = None) -> int:
    """Examine a drive; return the exit code: 0, 1 for a WARN or FAIL, 2 for bad input."""

    def examine() -> int:
        doctor = import_module("vehicle_doctor.command")
        ours, of_ros = split_ros_arguments(sys.argv[1:] if arguments is None else arguments)
        text = "Examine the signals of a drive, and learn the car from it."
        parser = ArgumentParser(prog="python3 -m vehicle_doctor", description=text)
        doctor.add_arguments(parser)
        return int(doctor.run(parser.parse_args(ours), of_ros))

    return command(examine)


if __name__ == "__main__":
    sys.exit(main())
