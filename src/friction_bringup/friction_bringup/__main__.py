"""Command line: ``python -m friction_bringup demo`` and ``monitor``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from friction_bags.bag_format import BagError
from friction_bringup import graph
from friction_bringup.demo import run_demo
from friction_bringup.demo_graph import DemoError, DemoOptions
from friction_bringup.monitor import run_monitor
from friction_bringup.recorded_run import parameters_of
from friction_runtime.parameters import shipped_file


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m friction_bringup", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("monitor", help="watch every wheel of a running graph; q ends")
    demo = commands.add_parser(
        "demo", help="brake from 30 m/s with the supervisor in the loop, or replay a bag, with a live view"
    )
    demo.add_argument("--surface", choices=graph.SURFACES, default="dry", help="road of the plant (default: dry)")
    demo.add_argument("--bag", type=Path, help="replay this bag in place of the plant")
    demo.add_argument(
        "--params", type=Path, help="parameter file (default: that of the demo, or the one the bag names)"
    )
    demo.add_argument("--out", type=Path, default=Path("out"), help="directory for the results (default: out)")
    options = parser.parse_args(arguments)
    if options.command == "monitor":
        return run_monitor()
    try:
        shipped = parameters_of(options.bag) if options.bag else "demo"
        params = options.params or shipped_file("friction_bringup", shipped)
        if not params.is_file():
            parser.error(f"parameter file {params} does not exist")
        return run_demo(DemoOptions(options.surface, options.bag, params.absolute(), options.out))
    except (DemoError, BagError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


def demo_main() -> int:
    """``ros2 run friction_bringup demo ...``."""
    return main(["demo", *sys.argv[1:]])


def monitor_main() -> int:
    """``ros2 run friction_bringup monitor``."""
    return main(["monitor"])


if __name__ == "__main__":
    sys.exit(main())
