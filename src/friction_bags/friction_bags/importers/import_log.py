"""`import`: makes a bag of this graph's topics from a table, a CAN log or a bag of any car."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Protocol

from friction_adapter.map_file import add_map_argument, load_map, shipped_maps
from friction_adapter.signal_map import SignalMap
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers.can_log import MDF_KIND, CanLog
from friction_bags.importers.log_kind import Kind, kind_of
from friction_bags.importers.mdf_log import MdfLog, channels_of
from friction_bags.importers.mdf_reader import has_frames
from friction_bags.importers.ros1_log import Ros1Log
from friction_bags.importers.table import ParquetTable, Table
from friction_bags.progress_bars import bars
from friction_bags.remapped_bag import RemappedBag, write_remapped
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output, Severity
from vehicle_models.vehicle_file import add_vehicle_argument

_SHOW_EVERY = 1000


class Log(Protocol):
    """A log, read through a signal map."""

    @property
    def notes(self) -> Sequence[str]:
        """How it was taken, where that is no problem; complete once it has been read."""

    def messages(self) -> Iterator[Output]:
        """Yield topics, with a leading slash, and messages."""

    def share(self) -> float:
        """Return the share that has been read."""

    def problems(self) -> Mapping[str, int]:
        """Return how often something could not be used, by what it is; 0 where that is a sentence of its own."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    kinds = "table, log or bag, recognised by its content; the name of a shipped map may stand before it"
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
        BagError: the file cannot be read, not one message comes of it, or the bag cannot be made.
        OSError: a file cannot be read or written.
        ParameterError: the map is not valid, or does not fit the log.
    """
    name, path = _map_and_log(args.log, args.map)
    return import_log(path, load_map(name, args.vehicle), args.dbc, args.out)


def import_log(path: Path, signal_map: SignalMap, dbc: Path | None, out: Path) -> int:
    """Make a bag of a log; as `run`.

    Args:
        path: log, table or bag.
        signal_map: the map.
        dbc: DBC file of a CAN log in place of that of the map; None for that of the map.
        out: bag to write.
    """
    if is_bag(path):
        return _import_bag(path, signal_map, out)
    for text in signal_map.cannot:
        _warn("warning", f"{signal_map.path}: {text}")
    log = open_log(path, signal_map, dbc)
    notes = {**signal_map.notes, VEHICLE_NOTE: signal_map.vehicle_reference}
    with bars([path.name]) as show:
        count = write_bag(out, _shown(path, log, show), notes)
    print(f"{out}: {count} messages from {path}")
    for text in log.notes:
        _warn("note", f"{path}: {text}")
    problems = _sentences(log)
    for text in problems:
        _warn("warning", f"{path}: {text}")
    return 1 if problems else 0


def is_bag(path: Path) -> bool:
    """Whether a path is that of a bag of ROS 2, which is no log.

    Raises:
        BagError: it is of a kind that is not read; the text names it.
        OSError: there is no such file.
    """
    return kind_of(path)[0] is Kind.BAG


def open_log(path: Path, signal_map: SignalMap, dbc: Path | None) -> Log:
    """Open a log by its content.

    Args:
        path: CAN log, MDF log, bag of ROS 1 or table.
        signal_map: the map.
        dbc: DBC file of a CAN log in place of that of the map; None for that of the map.

    Raises:
        BagError: it cannot be read.
        OSError: there is no such file.
        ParameterError: the map does not fit the log, or a package is not installed.
    """
    kind, suffix = kind_of(path)
    if kind in (Kind.CAN, Kind.FRAME_TEXT):
        return CanLog(path, signal_map, dbc, suffix)
    if kind is Kind.MDF:
        channels = channels_of(path)
        holds_frames = (dbc or signal_map.can.dbc) is not None and has_frames(list(channels))
        return CanLog(path, signal_map, dbc, MDF_KIND) if holds_frames else MdfLog(path, signal_map, channels)
    if kind is Kind.PARQUET:
        return ParquetTable(path, signal_map)
    return Ros1Log(path, signal_map) if kind is Kind.ROS_1 else Table(path, signal_map)


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


def _sentences(log: Log) -> list[str]:
    """Return what could not be used, with how often."""
    return [f"{text}{f', {times} times' if times else ''}" for text, times in log.problems().items()]


def _shown(path: Path, log: Log, show: Callable[[int, float], None]) -> Iterator[Output]:
    """Yield topics and messages.

    Raises:
        BagError: there is none.
    """
    number = -1
    for number, output in enumerate(log.messages()):
        if number % _SHOW_EVERY == 0:
            show(0, log.share())
        yield output
    if number < 0:
        raise BagError(f"{path}: not one message comes of it: {'; '.join(_sentences(log)) or 'it is empty'}")


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
