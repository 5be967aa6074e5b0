"""Recording of topics: found as they appear, taken as raw CDR, written in the order of their arrival."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import time_ns
from typing import NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.message_definition import message_definition
from friction_bags.record_replay import qos_profiles
from friction_bags.record_replay.foreign_type import raw_class
from friction_bags.record_replay.topic_selection import TopicSelection
from friction_runtime.message_type import UnknownTypeError


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
            profile = qos_profiles.matching(publishers)
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
        offered = tuple(qos_profiles.stored(publisher.qos_profile) for publisher in publishers)
        try:
            definition = message_definition(kind)
            topic = Topic(name, kind, definition.text, "ros2msg", definition.type_hash, offered)
            remark = ""
        except UnknownTypeError:
            topic = Topic(name, kind, type_hash=str(publishers[0].topic_type_hash), qos=offered)
            remark = "; the type is not installed here: without its definition"
        try:
            subscription = self._subscribe(topic, profile)
        except UnknownTypeError as error:
            self._refuse(name, str(error))
            return
        channel = self._writer.add_topic(topic)
        self.topics[name] = RecordedTopic(topic, channel, subscription, profile, publishers=len(publishers))
        self._say(f"recording {name} ({kind}, {profile.reliability.name.lower()}{remark})")

    def _resubscribe(self, recorded: RecordedTopic, profile: QoSProfile) -> None:
        """Match publishers that offer less or more than the previous ones."""
        self._drain(recorded, self._held)
        self._node.destroy_subscription(recorded.subscription)
        recorded.subscription = self._subscribe(recorded.topic, profile)
        recorded.profile = profile
        recorded.last_sequence = None
        self._say(f"recording {recorded.topic.name} again with {profile.reliability.name.lower()} QoS")

    def _subscribe(self, topic: Topic, profile: QoSProfile) -> Subscription:
        kind = raw_class(topic.type, topic.type_hash)
        return self._node.create_subscription(kind, topic.name, _never_called, profile, raw=True)

    def _refuse(self, name: str, reason: str) -> None:
        self._refused.add(name)
        self._say(f"NOT recording {name}: {reason}")


def _never_called(_: bytes) -> None:
    """Callback of subscriptions that are drained without an executor."""
