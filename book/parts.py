"""Studies of benchmarks and campaigns, run as by their command lines."""

import argparse
from collections.abc import Callable, Sequence
from functools import cache

from benchmarks.command import load_part
from benchmarks.rows import Row

Seeds = Callable[[int], str]
"""Number of seeds of this run, as an argument, from the full number."""
FEWEST = 20
"""Runs without which their middle 90 % say nothing of a number of a single run: as few at any effort."""
_MODULES = {"measured": "benchmarks.measured", "live": "campaigns.live.part"}


@cache
def rows_of(name: str, *arguments: str) -> Sequence[Row]:
    """Run a part with the arguments of its command line; the same ones are run once."""
    chosen = load_part(_MODULES.get(name, f"benchmarks.{name}.part"))
    parser = argparse.ArgumentParser(prog=name)
    chosen.add_arguments(parser)
    return chosen.run(parser.parse_args(arguments))
