"""Command line: `python3 -m friction_bags COMMAND ...`, and the executables of `ros2 run friction_bags ...`."""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from importlib import import_module

from friction_bags.bag_io.bag_format import BagError
from friction_parameters.command_line import command
from friction_runtime.message_type import UnknownTypeError

_NODES = {
    "record": ("record_replay.record", "record topics to a bag"),
    "play": ("record_replay.play", "replay a bag onto its topics"),
}
_TOOLS = {
    "info": ("bag_io.info", "show what a bag holds"),
    "reindex": ("bag_io.reindex", "repair a bag whose recorder was killed"),
    "process": ("offline.process", "run the estimators over bags, without middleware"),
    "import": ("importers.import_log", "make a bag from a table or log of any car, by a signal map"),
    "tutorial": ("experiments.tutorial", "write a simulated drive as a CAN log, to try the commands on"),
    "library": ("experiments.library", "make the recorded experiments of bags/ again"),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code."""
    return command(lambda: _run(argv), BagError, UnknownTypeError)


def _run(argv: Sequence[str] | None) -> int:
    """Load the module of the command, and only that one: some take a second."""
    ours, ros_args = _split(list(sys.argv[1:] if argv is None else argv))
    parser = ArgumentParser(prog="friction_bags", description="Record, replay, repair, import and process bags.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    module = None
    for name, (module_name, text) in {**_NODES, **_TOOLS}.items():
        described = commands.add_parser(name, help=text, description=text)
        if ours[:1] == [name]:
            module = import_module(f"friction_bags.{module_name}")
            module.add_arguments(described)
    args = parser.parse_args(ours)
    assert module is not None, "argparse has refused everything but a command in the first place"
    exit_code: int = module.run(args, ros_args) if args.command in _NODES else module.run(args)
    return exit_code


def _split(given: list[str]) -> tuple[list[str], list[str]]:
    """Split arguments into ours and those from --ros-args on (rclpy would remove OLD:=NEW from ours)."""
    at = given.index("--ros-args") if "--ros-args" in given else len(given)
    return given[:at], given[at:]


def record_main() -> int:
    """`ros2 run friction_bags record ...`."""
    return main(["record", *sys.argv[1:]])


def play_main() -> int:
    """`ros2 run friction_bags play ...`."""
    return main(["play", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
