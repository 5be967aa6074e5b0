"""`play`: replay of a bag onto its topics as raw CDR, so that header stamps do not change."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from time import monotonic

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.progress_bars import bars
from friction_bags.record_replay.flow_control import FlowControl, has_header, header_stamp
from friction_bags.record_replay.topics import TopicSelection, add_selection_arguments, replayed, selection_of
from friction_parameters.command_line import count, not_negative, positive
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.spin import StopFlag, made, start_middleware, stop_on_signals, take_down
from vehicle_models.nanoseconds import NANOSECONDS

_POLL_PERIOD = 0.005
_ACKNOWLEDGE_TIMEOUT = 20.0
"""[s] on an idle machine."""
_ACKNOWLEDGE_EVERY = 50
"""Messages after which a replay as fast as possible without flow control waits for reliable subscribers."""
_LONGEST_GAP = 600.0
"""Time without a message [s] that is passed over: a log of several drives, or of a clock that was set."""
_PERIOD = 0.1
"""Time [s] between looks at what has appeared."""


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bag", type=Path, help="directory of a bag, or an .mcap or .db3 file")
    add_selection_arguments(parser)
    parser.add_argument("--rate", type=positive, default=1.0, help="seconds of the bag per second (default 1)")
    parser.add_argument(
        "--as-fast-as-possible", action="store_true", help="do not pace by recording times; best with --follow"
    )
    parser.add_argument(
        "--follow",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="flow control: publish the next stamp when these have answered the last, such as '*/abs_supervisor'",
    )
    parser.add_argument(
        "--ahead", type=count, default=1, metavar="N", help="stamps --follow lets go unanswered (default 1)"
    )
    parser.add_argument("--namespace", default="", metavar="NS", help="put before every topic of the bag, such as /car")
    parser.add_argument("--loop", action="store_true", help="start again at the end")
    parser.add_argument("--start-offset", type=not_negative, default=0.0, metavar="S", help="start S s into the bag")
    parser.add_argument("--duration", type=positive, metavar="S", help="replay only S seconds of the bag")
    parser.add_argument(
        "--clock", type=positive, nargs="?", const=100.0, metavar="HZ", help="publish /clock (default 100 Hz)"
    )
    parser.add_argument(
        "--wait",
        type=not_negative,
        default=3.0,
        metavar="S",
        help="wait at most S until each topic has its subscribers (default 3: discovery can take 2.5 s)",
    )
    parser.add_argument(
        "--subscribers",
        nargs="+",
        type=_subscribers,
        default=[],
        metavar="[TOPIC=]N",
        help="subscribers to wait for, of one topic or of each that is not named (default 1)",
    )
    parser.add_argument(
        "--settle",
        type=not_negative,
        default=0.0,
        metavar="S",
        help="wait also until no new subscriber has come for S seconds (default 0)",
    )


def run(args: Namespace, ros_args: list[str]) -> int:
    """Replay until the end of the bag or a signal.

    Returns:
        Exit code: 0, 1 when the bag is damaged or not all was delivered.

    Raises:
        BagError: nothing can be replayed.
        ParameterError: the middleware does not accept a name or an argument, or nobody publishes what to follow.
    """
    stop = stop_on_signals()
    reader = BagReader(args.bag)
    start_middleware(ros_args)
    node = made(lambda: Node("player", enable_rosout=False, start_parameter_services=False))
    try:
        with reader:
            return _play(args, node, reader, stop)
    finally:
        take_down(node)


def _play(args: Namespace, node: Node, reader: BagReader, stop: StopFlag) -> int:
    selection = selection_of(args, node.get_namespace())
    topics = [topic for topic in reader.counts if selection.wants(topic.name)]
    namespace = f"/{args.namespace.strip('/')}".rstrip("/")
    player = made(lambda: Player(node, reader, topics, namespace))
    for name, reason in player.skipped.items():
        print(f"skipping {name}: {reason}", file=sys.stderr)
    if not player.topics:
        raise BagError(f"{args.bag}: no topic to replay")
    if args.clock:
        player.publish_clock(args.clock)
    start = reader.start + round(args.start_offset * NANOSECONDS)
    stop_at = reader.end + 1 if args.duration is None else start + round(args.duration * NANOSECONDS)
    span = Span(start, stop_at, args.start_offset > 0.0, args.duration is not None)
    if min(stop_at, reader.end + 1) <= start:
        raise BagError(f"{args.bag}: nothing behind --start-offset {args.start_offset} s")
    wanted = dict(args.subscribers)
    others = wanted.pop("", 1)
    for name in player.wait_for_subscribers(wanted, others, args.wait, stop, args.settle):
        print(f"{name}: less than {wanted.get(name, others)} subscribers after {args.wait} s", file=sys.stderr)
    rate = inf if args.as_fast_as_possible else args.rate
    flow = _flow_control(args, node, namespace or node.get_namespace(), stop) if args.follow else None
    if flow is not None and not flow.topics:
        raise ParameterError(f"no publisher of {' '.join(args.follow)}: start the nodes first")
    begun = monotonic()
    with bars([args.bag.name]) as show:
        progress = partial(show, 0)
        player.play(span, rate, stop, progress, flow)
        while args.loop and not stop.is_set():
            player.play(span, rate, stop, progress, flow)
    delivered = stop.is_set() or player.wait_for_delivery()
    for problem in reader.problems:
        print(f"damaged: {problem}", file=sys.stderr)
    if not delivered:
        print("some subscribers have not acknowledged everything", file=sys.stderr)
    late = "" if rate == inf else f", at most {player.latest * 1e3:.1f} ms late"
    print(
        f"{args.bag}: {player.published} messages on {len(player.topics)} topics replayed "
        f"in {monotonic() - begun:.1f} s{late}",
        flush=True,
    )
    return 0 if delivered and not reader.problems else 1


def _flow_control(args: Namespace, node: Node, namespace: str, stop: StopFlag) -> FlowControl:
    """Follow the topics that appear within the time for discovery, which ends once all named ones have appeared."""
    flow = FlowControl(node, args.ahead)
    selection = TopicSelection(args.follow, (), namespace)
    end = monotonic() + args.wait
    while not selection.is_complete(flow.topics) and monotonic() < end and not stop.is_set():
        flow.follow(selection)
        stop.wait(_PERIOD)
    while not flow.is_connected() and not stop.is_set() and monotonic() < end + args.wait:
        stop.wait(_PERIOD)
    return flow


def _subscribers(text: str) -> tuple[str, int]:
    """Read `TOPIC=N`, or N with an empty name: the topics that are not named."""
    name, _, number = text.rpartition("=")
    return _absolute(name) if name else "", count(number)


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


@dataclass(frozen=True)
class Span:
    """Part of a bag to replay."""

    start: int
    """First recording stamp [ns]."""
    stop: int
    """Recording stamp before which to stop [ns]."""
    is_after: bool
    """Whether messages before the first stamp are left out; else it is where the bag says that it begins."""
    is_before: bool
    """Whether those from the last stamp on are."""


class Player:
    """Publishes the messages of a bag when they are due."""

    def __init__(self, node: Node, reader: BagReader, topics: Sequence[Topic], namespace: str = "") -> None:
        """Make the publishers.

        Args:
            node: node that publishes.
            reader: the bag.
            topics: topics to replay.
            namespace: put before the names of the bag; with a leading slash, without one at the end.
        """
        self._node = node
        self._reader = reader
        self._publishers: dict[Topic, Publisher] = {}
        self._clock: Publisher | None = None
        self._clock_period = 0.0
        self.skipped: dict[str, str] = {}
        self.published = 0
        self.latest = 0.0
        for topic in topics:
            try:
                kind = message_class(topic.type)
            except UnknownTypeError as error:
                self.skipped[topic.name] = str(error)
                continue
            self._publishers[topic] = node.create_publisher(kind, namespace + topic.name, replayed(topic.qos))

    @property
    def topics(self) -> list[Topic]:
        """Topics that are replayed."""
        return list(self._publishers)

    def publish_clock(self, frequency: float) -> None:
        """Publish /clock, the recording time of the bag, at a frequency [Hz] of the replayed time."""
        self._clock = self._node.create_publisher(Clock, "/clock", 10)
        self._clock_period = 1.0 / frequency

    def wait_for_subscribers(
        self, wanted: Mapping[str, int], count: int, timeout: float, stop: StopFlag, settle: float = 0.0
    ) -> list[str]:
        """Wait until each topic has its subscribers and none has come for `settle` [s], at most `timeout` [s].

        Args:
            wanted: subscribers of topics, by the absolute name.
            count: subscribers of all other topics.
            timeout: longest wait [s].
            stop: flag that ends the wait.
            settle: time without a new subscriber [s].

        Returns:
            The topics that have fewer.
        """
        needed = [wanted.get(each.topic_name, count) for each in self._publishers.values()]
        now = monotonic()
        end, changed_at = now + timeout, now
        counts: list[int] = []
        while True:
            before, counts = counts, [each.get_subscription_count() for each in self._publishers.values()]
            now = monotonic()
            if counts != before:
                changed_at = now
            found = zip(self._publishers.values(), counts, needed, strict=True)
            short = [each.topic_name for each, there, least in found if there < least]
            if (not short and now - changed_at >= settle) or stop.is_set() or now >= end:
                return short
            stop.wait(_POLL_PERIOD)

    def play(
        self,
        span: Span,
        rate: float,
        stop: StopFlag,
        progress: Callable[[float], None],
        flow: FlowControl | None = None,
    ) -> None:
        """Replay once.

        Args:
            span: part of the bag.
            rate: seconds of the bag per second; inf: as fast as possible.
            stop: flag that ends the replay.
            progress: called with the share of the span that is done, 0 to 1, now and then.
            flow: flow control; holds the replay until the nodes have answered.
        """
        stamped = {topic for topic, publisher in self._publishers.items() if has_header(publisher.msg_type)}
        begun = monotonic()
        next_clock = 0.0
        start, stop_at = span.start if span.is_after else None, span.stop if span.is_before else None
        before, passed = span.start, 0.0
        for topic, stamp, data in self._reader.messages(self._publishers, start, stop_at):
            gap = (stamp - before) / NANOSECONDS
            if gap > _LONGEST_GAP:
                print(f"nothing for {gap:.0f} s before {topic.name}: passed over", file=sys.stderr)
                passed += gap
            before = max(before, stamp)
            offset = (stamp - span.start) / NANOSECONDS - passed
            while self._clock is not None and next_clock <= offset:
                self._sleep_until(begun + next_clock / rate, stop)
                self._tell_time(span.start + round((next_clock + passed) * NANOSECONDS))
                next_clock += self._clock_period
            self._sleep_until(begun + offset / rate, stop)
            if flow is not None and topic in stamped:
                flow.wait_for_turn(header_stamp(data), stop)
            elif flow is None and rate == inf and self.published % _ACKNOWLEDGE_EVERY == 0:
                self.wait_for_delivery()
            if stop.is_set():
                return
            self._publishers[topic].publish(data)
            self.published += 1
            if self.published % _ACKNOWLEDGE_EVERY == 0:
                progress((stamp - span.start) / (span.stop - span.start))
        if flow is not None:
            flow.wait_for_last(stop)

    def wait_for_delivery(self) -> bool:
        """Wait until reliable subscribers have acknowledged everything; return whether they have."""
        end = monotonic() + _ACKNOWLEDGE_TIMEOUT
        return all(
            publisher.wait_for_all_acked(Duration(seconds=max(end - monotonic(), 0.0)))
            for publisher in self._publishers.values()
        )

    def _sleep_until(self, due: float, stop: StopFlag) -> None:
        ahead = due - monotonic()
        if ahead > 0.0:
            stop.wait(ahead)
        else:
            self.latest = max(self.latest, -ahead)

    def _tell_time(self, now: int) -> None:
        assert self._clock is not None
        seconds, nanoseconds = divmod(now, NANOSECONDS)
        message = Clock()
        message.clock.sec, message.clock.nanosec = seconds, nanoseconds
        self._clock.publish(message)
