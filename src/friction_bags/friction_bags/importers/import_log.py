"""`import`: makes a bag of this graph's topics from a table, a CAN log or a bag of any car."""

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from friction_adapter.map_argument import add_map_argument
from friction_adapter.map_file import load_map, shipped_maps
from friction_bags.bag_io.message_bag import write_bag
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers.table import Table
from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle_argument import add_vehicle_argument


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "log",
        nargs="+",
        metavar="[MAP] LOG",
        help="table (CSV); a shipped map may stand before it",
    )
    add_map_argument(parser)
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
    name, log = _map_and_log(args.log, args.map)
    signal_map = load_map(name, args.vehicle)
    for text in signal_map.cannot:
        print(f"warning: {signal_map.path}: {text}", file=sys.stderr)
    table = Table(log, signal_map)
    notes = {**signal_map.notes, VEHICLE_NOTE: signal_map.vehicle_reference}
    count = write_bag(args.out, table.messages(), notes)
    print(f"{args.out}: {count} messages from {log}")
    troubles = table.mapper.troubles()
    for text, times in troubles.items():
        print(f"warning: {log}: {text}, {times} times", file=sys.stderr)
    return 1 if troubles else 0


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
