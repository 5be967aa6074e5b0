"""Command line: `python3 -m friction_bringup COMMAND ...`, or `ros2 run friction_bringup COMMAND ...`."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path

from friction_parameters.command_line import command, run_subcommand

_NODES = {
    "graph": ("friction_bringup.composed", "run the estimators in one process; takes --ros-args"),
    "doctor": ("vehicle_doctor.command", "examine the signals of a drive, as `python3 -m vehicle_doctor` does"),
    "monitor": ("friction_bringup.monitor", "watch every wheel of a running graph; q quits; takes --ros-args"),
}
_TOOLS = {
    "analyse": ("friction_bringup.analyse", "from a log of any car to its page: import, doctor, process, report"),
    "demo": ("friction_bringup.demo", "brake a simulated car with the supervisor in the loop, or replay a bag"),
    "policies": ("friction_bringup.security_policies", "print an SROS2 policy file for the nodes"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code: 1 where it failed or found a fault, 2 for bad input."""
    parser = ArgumentParser(
        prog="python3 -m friction_bringup",
        description="Start and watch the friction graph, and analyse drives with it.",
    )
    given = sys.argv[1:] if arguments is None else arguments
    return command(lambda: run_subcommand(parser, {**_NODES, **_TOOLS}, given, _NODES))


def executable() -> int:
    """Run the command that the executable is named after."""
    return main([Path(sys.argv[0]).name, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
