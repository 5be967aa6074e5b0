"""`analyse`: from a log of any car to its page: import, doctor, process and report, or a draft of its signal map."""

import sys
from argparse import ArgumentParser, Namespace
from functools import partial
from math import isfinite
from os import cpu_count
from pathlib import Path

from rich.console import Console
from rich.table import Table

from friction_adapter.map_file import add_map_argument, load_map
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.importers.draft_map import draft_map
from friction_bags.importers.import_log import import_log, is_bag
from friction_bags.importers.signal_list import ListedSignal, list_signals
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_bags.progress_bars import bars
from friction_bags.results.braking_rows import braking_rows
from friction_bags.results.braking_table import add_table_arguments, show_brakings
from friction_bags.results.run_reader import read_run
from friction_parameters.parameter import ParameterError
from friction_report.page import write_page
from friction_report.summary import print_summary
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_doctor.checks.accelerometer import UNKNOWN
from vehicle_doctor.command import read_drive
from vehicle_doctor.examine import examine, exit_code
from vehicle_doctor.findings import print_findings
from vehicle_models.vehicle_file import add_vehicle_argument, vehicle_reference

_NEEDED = ("wheel_speed", "acceleration")
"""Quantities without which little is estimated."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("log", type=Path, metavar="LOG", help="table, log or bag of any car; a bag of this graph")
    add_map_argument(parser)
    parser.add_argument("--dbc", type=Path, metavar="FILE", help="DBC file of a CAN log (default: that of the map)")
    add_vehicle_argument(parser, "that of the map, or of the bag")
    parser.add_argument("--out", type=Path, metavar="DIR", help="directory of the results (default: LOG_analysis)")
    add_table_arguments(parser)


def run(options: Namespace) -> int:
    """Analyse a log, or draft a map where none is given and the log is no bag of this graph.

    Returns:
        Exit code: 0, 1 where something of the log could not be used or the doctor found a fault.

    Raises:
        BagError: the log cannot be read, nothing comes of it, or the results exist.
        OSError: a file cannot be read or written.
        ParameterError: map, vehicle file or DBC file are bad.
    """
    log: Path = options.log
    if not options.map and not (is_bag(log) and _is_ours(log)):
        return _draft(log, options.dbc, options.vehicle)
    out: Path = options.out or log.with_name(f"{log.stem}_analysis")
    if out.exists():
        raise BagError(f"{out} exists: give another --out, or remove it; nothing is overwritten")
    bag, code = log, 0
    if options.map:
        bag = out / "drive"
        code = import_log(log, load_map(options.map, options.vehicle), options.dbc, bag)
    drive, _ = read_drive(bag, "", options.vehicle, None)
    findings = examine(drive, UNKNOWN)
    print_findings(f"{log}: {drive.vehicle.name}", findings)
    made = out / "estimates"
    with bars([f"processing {log.name}"]) as show:
        result = process_bag(bag, made, ProcessOptions(vehicle=options.vehicle), cpu_count() or 1, partial(show, 0))
    with bars([f"reading {made.name}"]) as show:
        read = read_run(made, None, "/", partial(show, 0))
    page = out / "page.html"
    write_page(read, page, log.resolve().name)
    print_summary(Console(), read)
    show_brakings(options, {log.resolve().name: braking_rows(read)}, Console())
    for problem in dict.fromkeys((*result.problems, *read.problems)):
        print(f"damaged: {problem}", file=sys.stderr)
    print(f"page  {page}")
    return max(code, exit_code(findings), int(bool(result.problems or read.problems)))


def _is_ours(bag: Path) -> bool:
    """Whether a bag holds topics of this graph."""
    with BagReader(bag) as reader:
        return any(topic.name == f"/{WHEEL_STATES}" and count for topic, count in reader.counts.items())


def _draft(log: Path, dbc: Path | None, vehicle: str) -> int:
    """List the signals of a log and write a draft of its map beside the user."""
    signals = list_signals(log, dbc)
    text, named = draft_map(signals, log, vehicle_reference(vehicle) if vehicle else "", dbc)
    _print_signals(signals)
    draft = Path(f"{log.stem}_map.yaml")
    if draft.exists():
        raise ParameterError(f"{draft} exists: give it as --map, or remove it for a new draft")
    draft.write_text(text, encoding="utf-8")
    print(text)
    missing = [name for name in _NEEDED if name not in named]
    if missing:
        print(f"not found by name: {', '.join(missing)}: add where they come from", file=sys.stderr)
    print(f"map   {draft}: look it through, then `analyse {log} --map {draft}`")
    return int(bool(missing))


def _print_signals(signals: list[ListedSignal]) -> None:
    table = Table("signal", "from", "unit", "rate [Hz]", "range", box=None)
    for each in signals:
        rate = f"{each.rate:.1f}" if isfinite(each.rate) else ""
        span = f"{each.low:.4g} to {each.high:.4g}" if isfinite(each.low) else ""
        table.add_row(each.name, each.source, each.unit, rate, span)
    Console().print(table)
