"""Other parts of the evaluation, run as by their command lines."""

import argparse
from collections.abc import Callable, Sequence
from functools import cache

from friction_evaluation.parts import part
from friction_evaluation.rows import Row

Seeds = Callable[[int], str]
"""Number of seeds of this run, as an argument, from the full number."""
FEWEST = 20
"""Runs without which their middle 90 % say nothing of a number of a single run: as few at any effort."""


@cache
def rows_of(name: str, *arguments: str) -> Sequence[Row]:
    """Run a part of the evaluation with the arguments of its command line; the same ones are run once."""
    chosen = part(name)
    parser = argparse.ArgumentParser(prog=name)
    chosen.add_arguments(parser)
    return chosen.run(parser.parse_args(arguments))
