"""Options of the doctor and the sources of a drive: a bag, a log of any car, or the topics of a running graph."""

import json
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console

from friction_adapter.map_file import add_map_argument, load_map
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode, type_name
from friction_bags.bag_vehicle import vehicle_for
from friction_bags.importers.import_log import is_bag, open_log
from friction_bags.offline.plan import SayOnce, open_bag
from friction_bags.results.braking_table import print_brakings, rows_of_bag
from friction_parameters.parameter import ParameterError
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import silent
from vehicle_doctor.checks.accelerometer import ROADS, UNKNOWN
from vehicle_doctor.drive import Drive, collect, kinds
from vehicle_doctor.examine import examine, exit_code
from vehicle_doctor.findings import as_json, print_findings
from vehicle_doctor.learned_vehicle import learned_file
from vehicle_doctor.live import listening
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import add_vehicle_argument, load_vehicle, vehicle_path


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("drive", type=Path, nargs="?", metavar="BAG|LOG", help="a bag, or with --map a log of any car")
    parser.add_argument(
        "--live", type=float, metavar="SECONDS", help="the running topics in place of a drive; takes --ros-args"
    )
    add_map_argument(parser)
    parser.add_argument("--dbc", type=Path, metavar="FILE", help="DBC file of a CAN log (default: that of the map)")
    add_vehicle_argument(parser, "that of the map, or of the bag")
    parser.add_argument("--road", choices=ROADS, default=UNKNOWN, help="what is known of the road's slope")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the findings to this file")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the vehicle file with what was learned")


def run(options: Namespace, of_ros: list[str]) -> int:
    """Examine a drive; return the exit code: 1 for a WARN or FAIL.

    Raises:
        BagError: the drive cannot be read.
        ParameterError: map or vehicle file are bad, or neither or both of a drive and --live are given.
        OSError: a file cannot be read or written.
    """
    if (options.drive is None) == (options.live is None):
        raise ParameterError("give a bag, a log or --live SECONDS, and one of these")
    if options.live is None:
        drive, source = read_drive(options.drive, options.map, options.vehicle, options.dbc)
        code = _examine(drive, source, str(options.drive), options)
        if not options.map and (brakings := rows_of_bag(options.drive, "/", lambda _: None)):
            print_brakings(Console(), options.drive.resolve().name, brakings)
        return code
    if options.map:
        raise ParameterError("--live hears the topics of this graph: start friction_adapter with the map beside it")
    source = vehicle_path(options.vehicle)
    with listening(load_vehicle(source), options.live, of_ros) as drive:
        return _examine(drive, source, f"{options.live:g} s live", options)


def _examine(drive: Drive, source: Path, name: str, options: Namespace) -> int:
    findings = examine(drive, options.road)
    print_findings(f"{name}: {drive.vehicle.name}", findings)
    if options.json is not None:
        options.json.write_text(json.dumps(as_json(findings), indent=1) + "\n", encoding="utf-8")
    if options.write is not None:
        text, left_out = learned_file(findings, source)
        options.write.write_text(text, encoding="utf-8")
        for reason in left_out:
            print(reason, file=sys.stderr)
    return exit_code(findings)


def read_drive(path: Path, map_name: str, vehicle: str, dbc: Path | None) -> tuple[Drive, Path]:
    """Read a bag or a log; return the drive and the vehicle file of its car.

    Raises:
        BagError: it cannot be read.
        ParameterError: the map or the vehicle file is bad, or a log has no map.
        OSError: a file cannot be read.
    """
    if is_bag(path):
        with open_bag(path, map_name, vehicle, "/", SayOnce()) as reader:
            source = vehicle_path(vehicle_for(reader, vehicle, "", silent))
            return _of_bag(reader, load_vehicle(source)), source
    if not map_name:
        raise ParameterError(f"{path} is no bag: a log needs --map")
    signal_map = load_map(map_name, vehicle)
    source = vehicle_path(signal_map.vehicle_reference)
    log = open_log(path, signal_map, dbc)
    wanted = kinds(signal_map.vehicle)
    others: set[str] = set()

    def of_log() -> Iterator[tuple[str, int, Any]]:
        for name, message in log.messages():
            topic = name.lstrip("/")
            if topic in wanted:
                yield topic, to_nanoseconds(message.header.stamp), message
            else:
                others.add(topic)

    drive = collect(signal_map.vehicle, of_log(), others)
    for text, times in log.problems().items():
        print(f"warning: {path}: {text}{f', {times} times' if times else ''}", file=sys.stderr)
    return drive, source


def _of_bag(reader: BagReader, vehicle: Vehicle) -> Drive:
    wanted = kinds(vehicle)
    topics: dict[Topic, type] = {}
    for topic in reader.counts:
        kind = wanted.get(topic.name.lstrip("/"))
        if kind is not None and type_name(kind) == topic.type:
            topics[topic] = kind
    others = {topic.name.lstrip("/") for topic in reader.counts if topic not in topics}

    def messages() -> Iterator[tuple[str, int, Any]]:
        for topic, recorded, data in reader.messages(topics):
            try:
                yield topic.name.lstrip("/"), recorded, decode(data, topics[topic])
            except ValueError as error:
                raise BagError(f"{reader.bag}: {topic.name}: {error}") from error

    return collect(vehicle, messages(), others)
