"""Command line: `python3 -m friction_bags COMMAND ...`, or `ros2 run friction_bags COMMAND ...`."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path

from friction_parameters.command_line import command, run_subcommand

_NODES = {
    "record": ("friction_bags.record_replay.recorder", "record topics to a bag"),
    "play": ("friction_bags.record_replay.player", "replay a bag onto its topics"),
}
_TOOLS = {
    "info": ("friction_bags.bag_io.info", "show what a bag holds"),
    "reindex": ("friction_bags.bag_io.reindex", "repair a bag whose recorder was killed"),
    "process": ("friction_bags.offline.process", "run the estimators over bags, without middleware"),
    "import": ("friction_bags.importers.import_log", "make a bag from a table or log of any car, by a signal map"),
    "tutorial": ("friction_bags.experiments.tutorial", "write a simulated drive as a CAN log, to try the commands on"),
    "library": ("friction_bags.experiments.library", "make the recorded experiments of bags/ again"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code."""
    parser = ArgumentParser(
        prog="python3 -m friction_bags", description="Record, replay, repair, import and process bags."
    )
    given = sys.argv[1:] if arguments is None else arguments
    return command(lambda: run_subcommand(parser, {**_NODES, **_TOOLS}, given, _NODES))


def executable() -> int:
    """Run the command that the executable is named after."""
    return main([Path(sys.argv[0]).name, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
