"""`record`: the command and the main loop of the recorder."""

import sys
from argparse import ArgumentParser, Namespace
from datetime import datetime
from pathlib import Path
from time import monotonic

from rclpy.node import Node
from rich.console import Console
from rich.table import Table

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.record_replay.recorder import Recorder
from friction_bags.record_replay.topic_selection import add_selection_arguments, selection_of
from friction_parameters.command_line import positive
from friction_parameters.parameter import ParameterError
from friction_runtime.spin import made, start_middleware, stop_on_signals, take_down
from friction_runtime.stop_flag import StopFlag
from vehicle_models.vehicle_file import add_vehicle_argument, load_vehicle, vehicle_reference

_TAKE_PERIOD = 0.02
_DISCOVER_PERIOD = 0.1
_FLUSH_PERIOD = 0.5
"""Period of flushing [s]. A killed recorder loses at most this, and one take period."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="directory to create (default: bag_ and the time)")
    parser.add_argument("--all", action="store_true", help="all topics, which is the default without --topics")
    add_selection_arguments(parser)
    parser.add_argument("--compression", choices=("zstd", "lz4", "none"), default="zstd", help="of chunks")
    parser.add_argument("--duration", type=positive, default=float("inf"), metavar="S", help="stop after S seconds")
    parser.add_argument("--note", default="", help="a note that travels with the bag")
    add_vehicle_argument(parser, "none; `process` then needs --vehicle")


def run(args: Namespace, ros_args: list[str]) -> int:
    """Record until a signal or the end of the duration.

    Returns:
        Exit code: 0, 1 when writing failed.

    Raises:
        BagError: the bag cannot be made.
        ParameterError: an option or the vehicle file is bad.
    """
    stop = stop_on_signals()
    if args.all and args.topics:
        raise ParameterError("give either --all or --topics")
    bag = args.out or Path(f"bag_{datetime.now():%Y_%m_%d-%H_%M_%S}")
    notes = _notes(args)
    start_middleware(ros_args)
    writer = BagWriter(bag, compression=args.compression, custom_data=notes)
    node = made(lambda: Node("recorder", enable_rosout=False, start_parameter_services=False))
    recorder = Recorder(node, writer, selection_of(args, node.get_namespace()), _say)
    _say(f"recording to {bag}; Ctrl-C ends it")
    try:
        _loop(recorder, writer, stop, args.duration)
        writer.close()
        _summarise(recorder, bag)
    except BagError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        take_down(node)
    return 0


def _notes(args: Namespace) -> dict[str, str]:
    notes = {"note": args.note} if args.note else {}
    if args.vehicle:
        load_vehicle(args.vehicle)  # a bag that names a bad file is of no use later
        notes[VEHICLE_NOTE] = vehicle_reference(args.vehicle)
    return notes


def _loop(recorder: Recorder, writer: BagWriter, stop: StopFlag, duration: float) -> None:
    begun = monotonic()
    discover_at = flush_at = begun
    while not stop.is_set() and (now := monotonic()) - begun < duration:
        if now >= discover_at:
            recorder.discover()
            discover_at = now + _DISCOVER_PERIOD
        recorder.take()
        if now >= flush_at:
            writer.flush()
            flush_at = now + _FLUSH_PERIOD
        stop.wait(_TAKE_PERIOD)
    recorder.take()
    recorder.finish()


def _say(line: str) -> None:
    print(line, flush=True)


def _summarise(recorder: Recorder, bag: Path) -> None:
    table = Table("topic", "type", "messages", "lost", box=None)
    for name, recorded in sorted(recorder.topics.items()):
        table.add_row(name, recorded.topic.type, str(recorded.count), str(recorded.lost))
    total = sum(recorded.count for recorded in recorder.topics.values())
    lost = sum(recorded.lost for recorded in recorder.topics.values())
    Console().print(table)
    _say(f"{bag}: {total} messages on {len(recorder.topics)} topics, {lost} lost; closed")
