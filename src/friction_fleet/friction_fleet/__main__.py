"""Command line: `python3 -m friction_fleet COMMAND ...`."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence

from friction_parameters.command_line import command, run_subcommand

_COMMANDS = {
    "process": ("friction_fleet.driver", "run the estimators over many bags, on this machine or a cluster"),
    "status": ("friction_fleet.status", "show how far `process` is, from the tables alone"),
    "map": ("friction_fleet.map_command", "make a map of friction from the tables"),
    "export": ("friction_fleet.export_command", "write a map for other systems"),
    "compact": ("friction_fleet.compact", "delete results of bags that were changed or processed again"),
    "simulate": ("friction_fleet.simulation.simulate", "make bags of a generated fleet whose roads are known"),
    "study": ("friction_fleet.study.command", "judge the map by a generated fleet, and the engine"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code."""
    parser = ArgumentParser(prog="python3 -m friction_fleet", description="Tables and maps of friction of a fleet.")
    given = sys.argv[1:] if arguments is None else arguments
    return command(lambda: run_subcommand(parser, _COMMANDS, given))


if __name__ == "__main__":
    sys.exit(main())
