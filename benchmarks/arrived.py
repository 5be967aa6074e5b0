"""Messages taken from a subscription without an executor: less work, and each comes with its time of publication."""

from collections.abc import Iterator
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

_DEPTH = 5000


def tap(node: Node, kind: type, topic: str) -> Subscription:
    """Return a reliable subscription from which `arrived` takes; no executor may spin the node."""
    profile = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.RELIABLE)
    return node.create_subscription(kind, topic, _never_called, profile)


def arrived(subscription: Subscription, raw: bool = False) -> Iterator[tuple[Any, int]]:
    """Yield what has arrived: the message, or its CDR bytes, and the wall clock of its publication [ns]."""
    while True:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, raw)
        if taken is None:
            return
        message, info = taken
        yield message, info["source_timestamp"]


def _never_called(_: Any) -> None:
    """Stand in for a callback."""
