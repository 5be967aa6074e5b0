"""Command line: ``python -m friction_bringup demo``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from friction_bringup import graph
from friction_bringup.demo import DemoError, DemoOptions, run_demo


def main(arguments: Sequence[str] | None = None) -> int:
    """Parse the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m friction_bringup", description=__doc__)
    demo = parser.add_subparsers(required=True, metavar="COMMAND").add_parser(
        "demo", help="brake from 30 m/s with the supervisor in the loop, or replay a bag, with a live view"
    )
    demo.add_argument("--surface", choices=graph.SURFACES, default="dry", help="road of the plant (default: dry)")
    demo.add_argument("--bag", type=Path, help="replay this bag in place of the plant")
    demo.add_argument("--params", type=Path, help="parameter file (default: the one shipped for the demo)")
    demo.add_argument("--out", type=Path, default=Path("out"), help="directory for the results (default: out)")
    options = parser.parse_args(arguments)
    params = options.params or graph.shipped_file("demo")
    for path in (params, options.bag):
        if path is not None and not path.exists():
            parser.error(f"{path} does not exist")
    try:
        return run_demo(DemoOptions(options.surface, options.bag, params.absolute(), options.out))
    except DemoError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
