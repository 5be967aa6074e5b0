"""`process`: the command that runs the estimators over bags, as fast as the machine allows."""

import signal
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from functools import partial
from multiprocessing import active_children, get_context
from os import cpu_count
from pathlib import Path

from rich.console import Console

from friction_adapter.map_file import add_map_argument
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_vehicle import CAR_OTHERWISE
from friction_bags.offline.estimators import ESTIMATORS
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import ProcessResult, process_bag
from friction_bags.progress_bars import bars
from friction_bags.results.braking_table import add_table_arguments, rows_of_bag, show_brakings
from friction_parameters.command_line import count
from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle_file import add_vehicle_argument

_REFRESH_PERIOD = 0.2


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="bags to process")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="bag to write; for several bags their directory",
    )
    parser.add_argument("--estimators", nargs="+", choices=ESTIMATORS, default=[], help="default: all with inputs")
    add_vehicle_argument(parser, CAR_OTHERWISE)
    parser.add_argument("--params-file", type=Path, action="append", default=[], help="ROS parameter file; repeatable")
    add_map_argument(parser)
    parser.add_argument("--namespace", default="/", help="namespace of the topics, such as /car")
    parser.add_argument("--outputs-only", action="store_true", help="leave out the topics of the bag")
    parser.add_argument(
        "--jobs", type=count, default=cpu_count() or 1, help="processes at once (default: one per core)"
    )
    add_table_arguments(parser)


def run(args: Namespace) -> int:
    """Process the bags.

    Returns:
        Exit code: 0, 1 when a bag is damaged, 2 when one could not be processed.

    Raises:
        BagError: two bags have the same name.
        KeyboardInterrupt: after SIGINT or SIGTERM. The bag being written is closed with what it has; of several bags at
            once, unfinished ones need a reindex.
    """
    options = ProcessOptions(
        tuple(args.estimators),
        args.vehicle,
        tuple(args.params_file),
        args.namespace,
        args.outputs_only,
        args.map,
    )
    outs = [args.out] if len(args.bags) == 1 else [args.out / bag.resolve().name for bag in args.bags]
    if len(set(outs)) < len(outs):
        raise BagError("two bags have the same name")
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    code, made = _report(outs, _process_all(list(zip(args.bags, outs, strict=True)), options, args.jobs))
    brakings = {}
    for out in made:
        with bars([f"reading {out.name}"]) as show:
            brakings[out.name] = rows_of_bag(out, options.prefix, partial(show, 0))
    show_brakings(args, brakings, Console())
    return code


def _report(outs: Sequence[Path], results: Iterable[ProcessResult | Exception]) -> tuple[int, list[Path]]:
    """Print what was done to each bag; return the exit code, and the bags that were written."""
    code, made = 0, []
    for out, result in zip(outs, results, strict=True):
        if isinstance(result, Exception):
            print(f"error: {result}", file=sys.stderr)
            code = 2
            continue
        made.append(out)
        for problem in result.problems:
            print(f"damaged: {problem}", file=sys.stderr)
            code = max(code, 1)
        print(
            f"{result.bag}: {result.messages} messages in, {result.outputs} out, {result.duration:.1f} s in "
            f"{result.seconds:.1f} s ({result.duration / result.seconds:.1f} times real time)",
            flush=True,
        )
    return code, made


def _process_all(
    pairs: Sequence[tuple[Path, Path]], options: ProcessOptions, jobs: int
) -> Iterator[ProcessResult | Exception]:
    """Process a bag in a chain of processes, or several bags at once; yield results in the order of the bags."""
    if len(pairs) == 1 or jobs == 1:
        for bag, out in pairs:
            with bars([bag.name]) as show:
                result = _attempt(bag, out, options, jobs, partial(show, 0))
            yield result
        return
    context = get_context("spawn")
    with context.Manager() as manager, ProcessPoolExecutor(min(jobs, len(pairs)), mp_context=context) as pool:
        parts = manager.dict({index: 0.0 for index in range(len(pairs))})
        futures = [
            pool.submit(_attempt, bag, out, options, 1, partial(parts.__setitem__, index))
            for index, (bag, out) in enumerate(pairs)
        ]
        try:
            with bars([bag.name for bag, _ in pairs]) as show:
                while wait(futures, _REFRESH_PERIOD).not_done:
                    for index, part in parts.items():
                        show(index, part)
        except KeyboardInterrupt:
            for child in active_children():
                child.terminate()
            raise
        yield from (future.result() for future in futures)


def _attempt(
    bag: Path, out: Path, options: ProcessOptions, processes: int, progress: Callable[[float], None]
) -> ProcessResult | Exception:
    """Process a bag; return what went wrong instead of raising it, so that the other bags go on."""
    try:
        return process_bag(bag, out, options, processes, progress)
    except (BagError, ParameterError, OSError) as error:
        return error
