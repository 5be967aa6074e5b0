"""`import`: makes a bag of this graph's topics from a table, a CAN log or a bag of any car."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Protocol

from friction_adapter.map_file import add_map_argument, load_map, shipped_maps
from friction_adapter.signal_map import SignalMap
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers import can_log, mdf_log, ros1_log, table
from friction_bags.importers.can_log import CanLog, is_can_log
from friction_bags.importers.mdf_log import MdfLog
from friction_bags.importers.ros1_log import Ros1Log
from friction_bags.importers.table import ParquetTable, Table
from friction_bags.progress_bars import bars
from friction_bags.remapped_bag import RemappedBag, write_remapped
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output, Severity
from vehicle_models.vehicle_file import add_vehicle_argument

_BAG_SUFFIXES = (".mcap", ".db3", ".zstd")
_SHOW_EVERY = 1000


class Log(Protocol):
    """A log, read through a signal map."""

    def messages(self) -> Iterator[Output]:
        """Yield topics, with a leading slash, and messages."""

    def share(self) -> float:
        """Return the share that has been read."""

    def problems(self) -> Mapping[str, int]:
        """Return how often something could not be used, by what it is; 0 where that is a sentence of its own."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    logs = ", ".join((*can_log.SUFFIXES, *mdf_log.SUFFIXES))
    tables = f"CSV, {table.PARQUET}"
    kinds = f"table ({tables}), log ({logs}) or bag of ROS 2 or 1; the name of a shipped map may stand before it"
    parser.add_argument("log", nargs="+", metavar="[MAP] LOG", help=kinds)
    add_map_argument(parser)
    parser.add_argument("--dbc", type=Path, metavar="FILE", help="DBC file of a CAN log (default: that of the map)")
    add_vehicle_argument(parser, "that of the map")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="bag to write")


def run(args: Namespace) -> int:
    """Import a file.

    Returns:
        Exit code: 0, 1 when something of the log could not be used.

    Raises:
        BagError: the file cannot be read or the bag cannot be made.
        OSError: a file cannot be read or written.
        ParameterError: the map is not valid, or does not fit the log.
    """
    name, path = _map_and_log(args.log, args.map)
    signal_map = load_map(name, args.vehicle)
    if is_bag(path):
        return _import_bag(path, signal_map, args.out)
    for text in signal_map.cannot:
        _warn("warning", f"{signal_map.path}: {text}")
    log = open_log(path, signal_map, args.dbc)
    for text in log.notes if isinstance(log, CanLog) else ():
        _warn("note", text)
    notes = {**signal_map.notes, VEHICLE_NOTE: signal_map.vehicle_reference}
    with bars([path.name]) as show:
        count = write_bag(args.out, _shown(log, show), notes)
    print(f"{args.out}: {count} messages from {path}")
    problems = log.problems()
    for text, times in problems.items():
        _warn("warning", f"{path}: {text}{f', {times} times' if times else ''}")
    return 1 if problems else 0


def is_bag(path: Path) -> bool:
    """Whether a path is that of a bag of ROS 2, which is no log."""
    return path.is_dir() or path.suffix in _BAG_SUFFIXES


def open_log(path: Path, signal_map: SignalMap, dbc: Path | None) -> Log:
    """Open a log by its suffix.

    Args:
        path: CAN log, MDF log, bag of ROS 1 or table.
        signal_map: the map.
        dbc: DBC file of a CAN log in place of that of the map; None for that of the map.

    Raises:
        BagError: it cannot be read.
        OSError: there is no such file.
        ParameterError: the map does not fit the log, or a package is not installed.
    """
    if is_can_log(path):
        return CanLog(path, signal_map, dbc)
    if path.suffix.lower() in mdf_log.SUFFIXES:
        return MdfLog(path, signal_map)
    if path.suffix.lower() == table.PARQUET:
        return ParquetTable(path, signal_map)
    return Ros1Log(path, signal_map) if path.suffix == ros1_log.SUFFIX else Table(path, signal_map)


def _import_bag(path: Path, signal_map: SignalMap, out: Path) -> int:
    """Write what a map makes of a bag; return the exit code."""
    warnings: list[str] = []

    def report(severity: Severity, text: str) -> None:
        if severity in ("warning", "error") and text not in warnings:
            warnings.append(text)
            _warn(severity, text)

    with RemappedBag(path, signal_map, report) as bag, bars([path.name]) as show:
        known = len(warnings)  # what the map lacks is no problem of this bag
        count = write_remapped(bag, out, signal_map.notes, partial(show, 0))
        problems = list(bag.problems)
    for problem in problems:
        _warn("damaged", problem)
    print(f"{out}: {count} messages from {path}")
    return 1 if problems or len(warnings) > known else 0


def _warn(severity: str, text: str) -> None:
    print(f"{severity}: {text}", file=sys.stderr)


def _shown(log: Log, show: Callable[[int, float], None]) -> Iterator[Output]:
    for number, output in enumerate(log.messages()):
        if number % _SHOW_EVERY == 0:
            show(0, log.share())
        yield output


def _map_and_log(given: list[str], map_name: str) -> tuple[str, Path]:
    """Return map and log from `LOG --map MAP` or `MAP LOG`.

    Raises:
        ParameterError: there is no map, or more than a log.
    """
    if len(given) == 1 and map_name:
        return map_name, Path(given[0])
    if len(given) == 2 and not map_name and given[0] in shipped_maps():
        return given[0], Path(given[1])
    raise ParameterError(f"give LOG --map MAP, or one of {', '.join(shipped_maps())} before LOG")
