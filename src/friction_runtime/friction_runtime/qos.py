"""Quality of service of the graph: sensors best effort, estimates reliable, commands with a deadline.

All are overridable by parameters.
"""

from collections.abc import Callable
from copy import copy
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

_DEPTH = 100
"""Samples a queue holds: 0.5 s at 200 Hz."""
COMMAND_DEADLINE = 0.05
"""Longest time between two commands [s]: a supervisor sends one at least every 20 ms."""
COMMAND_LEASE = 0.2
"""The process of a commanding supervisor shows within this time [s] that it is alive."""
_UNLIMITED = Duration()
_POLICIES = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
"""What parameters may override for every topic."""
_COMMAND_POLICIES = (
    *_POLICIES,
    QoSPolicyKind.DEADLINE,
    QoSPolicyKind.LIFESPAN,
    QoSPolicyKind.LIVELINESS,
    QoSPolicyKind.LIVELINESS_LEASE_DURATION,
)
"""What they may override for commands."""


def _profile(reliability: ReliabilityPolicy) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=_DEPTH, reliability=reliability, durability=DurabilityPolicy.VOLATILE
    )


SENSOR = _profile(ReliabilityPolicy.BEST_EFFORT)
"""For subscriptions to sensors, and to whatever a node reads that commands in real time: matches best-effort and
reliable publishers."""
ESTIMATE = _profile(ReliabilityPolicy.RELIABLE)
"""For estimates, tyre blocks, replay and recording. It matches commands too, and asks nothing of them."""


def command(lifespan: float) -> QoSProfile:
    """Return the profile of a publisher of commands, which it does not send again once they are `lifespan` [s] old."""
    return _command(Duration(seconds=lifespan))


def _command(lifespan: Duration) -> QoSProfile:
    profile = _profile(ReliabilityPolicy.RELIABLE)
    profile.deadline = Duration(seconds=COMMAND_DEADLINE)
    profile.lifespan = lifespan
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=COMMAND_LEASE)
    return profile


COMMAND = _command(_UNLIMITED)
"""For the consumer of commands, which is notified of a missed deadline and a lost liveliness. It matches only
publishers that promise both. It judges the age of a command by its stamp, so it asks for no lifespan."""


def subscribe(
    node: Node,
    kind: type,
    topic: str,
    callback: Callable[[Any], object],
    profile: QoSProfile,
    events: SubscriptionEventCallbacks | None = None,
) -> Subscription:
    """Subscribe with QoS overriding on.

    Args:
        node: the node that subscribes.
        kind: message class.
        topic: relative or full name.
        callback: takes each message.
        profile: QoS.
        events: callbacks for what the middleware reports.
    """
    # a copy: rclpy writes the overrides of this topic into the profile it is given
    options = _overriding(profile)
    return node.create_subscription(
        kind, topic, callback, copy(profile), event_callbacks=events, qos_overriding_options=options
    )


def publish(node: Node, kind: type, topic: str, profile: QoSProfile = ESTIMATE) -> Publisher:
    """Make a publisher with QoS overriding on."""
    return node.create_publisher(kind, topic, copy(profile), qos_overriding_options=_overriding(profile))


def _overriding(profile: QoSProfile) -> QoSOverridingOptions:
    return QoSOverridingOptions(_POLICIES if profile.deadline == _UNLIMITED else _COMMAND_POLICIES)
