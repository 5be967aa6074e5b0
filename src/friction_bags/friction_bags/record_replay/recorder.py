"""`record`: topics to a bag, found as they appear, taken as raw CDR, written in the order of their arrival."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from time import monotonic, time_ns
from typing import NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rich.console import Console
from rich.table import Table

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import message_definition
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.record_replay.topics import TopicSelection, add_selection_arguments, matching, selection_of, stored
from friction_parameters.command_line import positive
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.spin import StopFlag, made, start_middleware, stop_on_signals, take_down
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


class _Taken(NamedTuple):
    """A received message; tuples sort by the time of arrival."""

    received: int
    channel: int
    sequence: int
    sent: int
    data: bytes


@dataclass
class RecordedTopic:
    """A topic that is being recorded."""

    topic: Topic
    channel: int
    subscription: Subscription
    profile: QoSProfile
    publishers: int
    count: int = 0
    lost: int = 0
    """Messages missing in the sequence of a topic's only publisher."""
    last_sequence: int | None = None


class Recorder:
    """Subscribes to the selected topics of a graph and writes what arrives.

    The subscriptions are drained by `take`, called periodically, instead of by an executor: that costs microseconds per
    message, and the middleware stamps each arrival. The node is never spun.
    """

    def __init__(self, node: Node, writer: BagWriter, selection: TopicSelection, say: Callable[[str], None]) -> None:
        """Start with no topic.

        Args:
            node: node that subscribes.
            writer: writer of the bag.
            selection: selected topics.
            say: prints a line for the user.
        """
        self._node = node
        self._writer = writer
        self._selection = selection
        self._say = say
        self._refused: set[str] = set()
        self._held: list[_Taken] = []
        self.topics: dict[str, RecordedTopic] = {}

    def discover(self) -> None:
        """Subscribe to selected topics that have appeared, and follow publishers that have changed."""
        for name, types in self._node.get_topic_names_and_types():
            if "/_" in name or name in self._refused or not self._selection.wants(name):
                continue
            publishers = self._node.get_publishers_info_by_topic(name)
            if not publishers:
                continue
            profile = matching(publishers)
            recorded = self.topics.get(name)
            if recorded is None:
                if len(types) > 1:
                    self._refuse(name, f"it has several types ({', '.join(types)})")
                    continue
                self._begin(name, types[0], publishers, profile)
                continue
            recorded.publishers = len(publishers)
            if profile != recorded.profile:
                self._resubscribe(recorded, profile)

    def take(self) -> None:
        """Write what has arrived.

        Raises:
            BagError: the bag cannot be written.
        """
        now = time_ns()
        arrived: list[_Taken] = []
        for recorded in self.topics.values():
            self._drain(recorded, arrived)
        ready = self._held + [taken for taken in arrived if taken.received <= now]
        self._held = [taken for taken in arrived if taken.received > now]
        for taken in sorted(ready):
            self._write(taken)

    def finish(self) -> None:
        """Write what `take` held back because it arrived while others were taken."""
        held, self._held = self._held, []
        for taken in sorted(held):
            self._write(taken)

    def _write(self, taken: _Taken) -> None:
        self._writer.write(taken.channel, taken.received, taken.data, taken.sent, taken.sequence)

    def _drain(self, recorded: RecordedTopic, arrived: list[_Taken]) -> None:
        handle = recorded.subscription.handle
        with handle:
            while (message := handle.take_message(recorded.subscription.msg_type, True)) is not None:
                data, info = message
                received = info["received_timestamp"] or time_ns()
                sequence = info["publication_sequence_number"] or 0
                arrived.append(_Taken(received, recorded.channel, sequence, info["source_timestamp"] or received, data))
                recorded.count += 1
                if recorded.publishers == 1 and recorded.last_sequence is not None:
                    recorded.lost += max(sequence - recorded.last_sequence - 1, 0)
                recorded.last_sequence = sequence or None

    def _begin(self, name: str, kind: str, publishers: Sequence[TopicEndpointInfo], profile: QoSProfile) -> None:
        offered = tuple(stored(publisher.qos_profile) for publisher in publishers)
        try:
            definition = message_definition(kind)
            topic = Topic(name, kind, definition.text, "ros2msg", definition.type_hash, offered)
            subscription = self._subscribe(topic, profile)
        except UnknownTypeError as error:
            self._refuse(name, str(error))
            return
        channel = self._writer.add_topic(topic)
        self.topics[name] = RecordedTopic(topic, channel, subscription, profile, publishers=len(publishers))
        self._say(f"recording {name} ({kind}, {profile.reliability.name.lower()})")

    def _resubscribe(self, recorded: RecordedTopic, profile: QoSProfile) -> None:
        """Match publishers that offer less or more than the previous ones."""
        self._drain(recorded, self._held)
        self._node.destroy_subscription(recorded.subscription)
        recorded.subscription = self._subscribe(recorded.topic, profile)
        recorded.profile = profile
        recorded.last_sequence = None
        self._say(f"recording {recorded.topic.name} again with {profile.reliability.name.lower()} QoS")

    def _subscribe(self, topic: Topic, profile: QoSProfile) -> Subscription:
        return self._node.create_subscription(message_class(topic.type), topic.name, _never_called, profile, raw=True)

    def _refuse(self, name: str, reason: str) -> None:
        self._refused.add(name)
        self._say(f"NOT recording {name}: {reason}")


def _never_called(_: bytes) -> None:
    """Callback of subscriptions that are drained without an executor."""
