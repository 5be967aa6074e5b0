"""Quality of service of the graph: sensors best effort, estimates reliable, all overridable by parameters."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

_DEPTH = 100
"""Samples a queue holds: 0.5 s at 200 Hz."""


def _profile(reliability: ReliabilityPolicy) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=_DEPTH, reliability=reliability, durability=DurabilityPolicy.VOLATILE
    )


SENSOR = _profile(ReliabilityPolicy.BEST_EFFORT)
"""For subscriptions to sensors: matches best-effort and reliable publishers."""
ESTIMATE = _profile(ReliabilityPolicy.RELIABLE)
"""For estimates, tyre blocks, commands, replay and recording."""


def subscribe(node: Node, kind: type, topic: str, callback: Callable[[Any], None], profile: QoSProfile) -> Subscription:
    """Subscribe with QoS overriding on."""
    return node.create_subscription(
        kind, topic, callback, profile, qos_overriding_options=QoSOverridingOptions.with_default_policies()
    )


def publish(node: Node, kind: type, topic: str, profile: QoSProfile = ESTIMATE) -> Publisher:
    """Make a publisher with QoS overriding on."""
    return node.create_publisher(
        kind, topic, profile, qos_overriding_options=QoSOverridingOptions.with_default_policies()
    )
