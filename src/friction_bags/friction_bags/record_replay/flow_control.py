"""Flow control of a replay: the next samples are published when the nodes have answered the previous ones."""

import struct
from collections import deque
from time import monotonic
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription

from friction_bags.record_replay.topics import TopicSelection, matching
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.spin import StopFlag
from vehicle_models.nanoseconds import NANOSECONDS

_POLL_PERIOD = 0.0002
_PATIENCE = 2.0
"""Silence after which more stamps are let through [s]: some answers need a later sample."""
_LONGEST_STALL = 20.0
"""The same for a topic that has answered with as many stamps under way as are allowed now: its node is held up [s]."""
_MOST_AHEAD = 40
"""Stamps under way: best-effort samples of more overflow the queues of a node that stands still."""
_LITTLE = struct.Struct("<iI")
_BIG = struct.Struct(">iI")


class FlowControl:
    """Holds the replay until every followed topic has a message stamped like the sample before, or later.

    Some topics answer only after later samples. So after a second of silence twice as many stamps may be under way for
    that topic: the replay never blocks, and is slow only once. A topic that has answered since is waited for longer,
    because its node may only stand still. Topics that answer at once are still waited for, so that their samples do
    not arrive late because of a slow topic.
    """

    def __init__(self, node: Node, ahead: int = 1) -> None:
        """Follow nothing yet; `ahead` stamps may be outstanding without an answer."""
        self._node = node
        self._first_ahead = ahead
        self._followed: dict[str, tuple[Subscription, Any]] = {}
        self._reached: dict[str, int] = {}
        self._ahead: dict[str, int] = {}
        self._answered: set[str] = set()
        self._under_way: deque[int] = deque()
        self._last = 0

    @property
    def topics(self) -> list[str]:
        """Topics that are followed."""
        return list(self._followed)

    def follow(self, selection: TopicSelection) -> None:
        """Follow the selected topics that have publishers now and messages with a header."""
        for name, types in self._node.get_topic_names_and_types():
            if name in self._followed or not selection.wants(name) or not self._node.count_publishers(name):
                continue
            try:
                kind: Any = message_class(types[0])
            except UnknownTypeError:
                continue
            if has_header(kind):
                profile = matching(self._node.get_publishers_info_by_topic(name))
                subscription = self._node.create_subscription(kind, name, _never_called, profile, raw=True)
                self._followed[name] = (subscription, kind)
                self._reached[name] = 0
                self._ahead[name] = self._first_ahead

    def is_connected(self) -> bool:
        """Whether every followed topic has found its publisher."""
        return all(subscription.get_publisher_count() for subscription, _ in self._followed.values())

    def wait_for_turn(self, stamp: int, stop: StopFlag) -> None:
        """Return when a sample with this header stamp [ns] may be published."""
        if stamp < self._last:
            self._under_way.clear()
            self._reached = dict.fromkeys(self._reached, 0)
        elif stamp == self._last or not self._followed:
            return
        since = monotonic()
        while not stop.is_set():
            self._take()
            while self._under_way and self._under_way[0] <= min(self._reached.values(), default=stamp):
                self._under_way.popleft()
                since = monotonic()
            late = [name for name in self._reached if self._unanswered(name) >= self._ahead[name]]
            if not late:
                break
            silence = monotonic() - since
            for name in late:
                patience = _LONGEST_STALL if name in self._answered else _PATIENCE
                if silence > patience:
                    self._let_more(name)
                    since = monotonic()
            stop.wait(_POLL_PERIOD)
        self._under_way.append(stamp)
        self._last = stamp

    def _let_more(self, topic: str) -> None:
        self._answered.discard(topic)
        if self._ahead[topic] >= _MOST_AHEAD:
            self._node.get_logger().warning(f"{topic}: no answer to {self._ahead[topic]} stamps, not followed any more")
            self._node.destroy_subscription(self._followed.pop(topic)[0])
            del self._reached[topic]
        else:
            self._ahead[topic] = min(2 * self._ahead[topic], _MOST_AHEAD)

    def _unanswered(self, topic: str) -> int:
        return sum(stamp > self._reached[topic] for stamp in self._under_way)

    def wait_for_last(self, stop: StopFlag) -> None:
        """Return when the last sample was answered, or after a second of silence."""
        since = monotonic()
        while self._under_way and not stop.is_set() and monotonic() - since < _PATIENCE:
            if self._take():
                since = monotonic()
            while self._under_way and self._under_way[0] <= min(self._reached.values(), default=self._last):
                self._under_way.popleft()
            stop.wait(_POLL_PERIOD)

    def _take(self) -> int:
        count = 0
        for name, (subscription, kind) in self._followed.items():
            with subscription.handle:
                while (message := subscription.handle.take_message(kind, True)) is not None:
                    self._reached[name] = header_stamp(message[0])
                    self._answered.add(name)
                    count += 1
        return count


def has_header(kind: Any) -> bool:
    """Whether messages of a class begin with a header."""
    return next(iter(kind.get_fields_and_field_types().values()), "") == "std_msgs/Header"


def header_stamp(data: bytes) -> int:
    """Return the stamp [ns] of the header at the start of a CDR message."""
    seconds, nanoseconds = (_LITTLE if data[1] & 1 else _BIG).unpack_from(data, 4)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def _never_called(_: bytes) -> None:
    """Callback of subscriptions that are drained without an executor."""
