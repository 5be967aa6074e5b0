"""Options of the report, and the estimates of a bag that holds none."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from os import cpu_count
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from friction_adapter.map_file import add_map_argument
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_vehicle import CAR_OTHERWISE
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_bags.progress_bars import bars
from friction_bags.results.braking_rows import braking_rows
from friction_bags.results.braking_table import add_table_arguments, show_brakings
from friction_bags.results.run_reader import read_run
from friction_report.page import refuse_existing, write_page
from vehicle_models.vehicle_file import add_vehicle_argument

_ABOUT = "Show a drive as one page for a browser."
_ESTIMATES = ("WheelSlip", "FrictionSlope", "FrictionCurve", "SupervisorState", "ContactPatch", "TyreForce")
_MADE = "The bag holds no estimates: they were made for this page, as `process` makes them."


def run(arguments: Sequence[str] | None = None) -> int:
    """Write the page of a bag. A bag without estimates is processed on the way.

    Returns:
        Exit code: 0, 1 when the bag is damaged.

    Raises:
        BagError: the bag cannot be read, nothing of it can be shown, or the page exists.
        ParameterError: the bag must be processed, and its car, a parameter or the map is not known or bad.
        OSError: the page cannot be written.
    """
    args = _parser().parse_args(arguments)
    refuse_existing(args.out)
    options = ProcessOptions((), args.vehicle, tuple(args.params_file), args.namespace, False, args.map)
    with _with_estimates(args.bag, options) as (bag, remarks, faults):
        with bars([f"reading {args.bag.name}"]) as show:
            read = read_run(bag, None, options.prefix, partial(show, 0))
        read = replace(read, problems=tuple(dict.fromkeys([*faults, *read.problems])))
        write_page(read, args.out, args.bag.resolve().name, remarks)
    for problem in read.problems:
        print(f"damaged: {problem}", file=sys.stderr)
    show_brakings(args, {args.bag.resolve().name: braking_rows(read)}, Console())
    print(f"page  {args.out}  {args.out.stat().st_size / 1e6:.1f} MB, {len(read.series)} topics")
    return 1 if read.problems else 0


def _parser() -> ArgumentParser:
    parser = ArgumentParser(prog="python3 -m friction_report", description=_ABOUT)
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag to show")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="HTML file to write")
    parser.add_argument("--namespace", default="/", help="namespace of the topics, such as /car")
    add_vehicle_argument(parser, CAR_OTHERWISE)
    add_map_argument(parser)
    parser.add_argument(
        "--params-file", type=Path, action="append", default=[], help="ROS parameter file of the estimators; repeatable"
    )
    add_table_arguments(parser)
    return parser


@contextmanager
def _with_estimates(bag: Path, options: ProcessOptions) -> Iterator[tuple[Path, list[str], tuple[str, ...]]]:
    """Yield the bag, or one made of it with estimates, remarks on that, and the damage."""
    if not options.map_file:
        with BagReader(bag) as reader:
            there = any(_is_estimate(topic.name, topic.type, options.prefix) for topic in reader.counts)
        if there:
            yield bag, [], ()
            return
    with TemporaryDirectory(prefix="friction_report_") as directory:
        made = Path(directory, "bag")
        with bars([f"processing {bag.name}"]) as show:
            result = process_bag(bag, made, options, cpu_count() or 1, partial(show, 0))
        yield made, [_MADE], result.problems


def _is_estimate(name: str, kind: str, prefix: str) -> bool:
    return kind.rpartition("/")[2] in _ESTIMATES and not name.removeprefix(prefix).startswith("truth/")
