"""Replay of a bag onto its topics as raw CDR, so that header stamps do not change."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from time import monotonic

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.record_replay import qos_profiles
from friction_bags.record_replay.flow_control import FlowControl, has_header, header_stamp
from friction_bags.record_replay.foreign_type import raw_class
from friction_runtime.machine_load import slowdown
from friction_runtime.message_type import UnknownTypeError
from friction_runtime.stop_flag import StopFlag
from vehicle_models.nanoseconds import NANOSECONDS

_POLL_PERIOD = 0.005
_ACKNOWLEDGE_TIMEOUT = 5.0
"""[s] on an idle machine."""
_ACKNOWLEDGE_EVERY = 50
"""Messages after which a replay as fast as possible without flow control waits for reliable subscribers."""


@dataclass(frozen=True)
class Span:
    """Part of a bag to replay."""

    start: int
    """First recording stamp [ns]."""
    stop: int
    """Recording stamp before which to stop [ns]."""


class Player:
    """Publishes the messages of a bag when they are due."""

    def __init__(self, node: Node, reader: BagReader, topics: Sequence[Topic], remapping: Mapping[str, str]) -> None:
        """Make the publishers.

        Args:
            node: node that publishes.
            reader: the bag.
            topics: topics to replay.
            remapping: new names of topics.
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
                kind = raw_class(topic.type, topic.type_hash)
            except UnknownTypeError as error:
                self.skipped[topic.name] = str(error)
                continue
            name = remapping.get(topic.name, topic.name)
            self._publishers[topic] = node.create_publisher(kind, name, qos_profiles.replayed(topic.qos))

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
            progress: called with the time into the span [s] after each message.
            flow: flow control; holds the replay until the nodes have answered.
        """
        stamped = {topic for topic, publisher in self._publishers.items() if has_header(publisher.msg_type)}
        begun = monotonic()
        next_clock = 0.0
        for topic, stamp, data in self._reader.messages(self._publishers, span.start, span.stop):
            offset = (stamp - span.start) / NANOSECONDS
            while self._clock is not None and next_clock <= offset:
                self._sleep_until(begun + next_clock / rate, stop)
                self._tell_time(span.start + round(next_clock * NANOSECONDS))
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
            progress(offset)
        if flow is not None:
            flow.wait_for_last(stop)

    def wait_for_delivery(self) -> bool:
        """Wait until reliable subscribers have acknowledged everything; return whether they have."""
        end = monotonic() + _ACKNOWLEDGE_TIMEOUT * slowdown()
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
