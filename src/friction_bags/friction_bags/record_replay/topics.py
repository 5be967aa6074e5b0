"""Topics of the recorder and the player: their selection by name, and their QoS in the graph and in a bag."""

from argparse import ArgumentParser, Namespace
from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from vehicle_models.nanoseconds import NANOSECONDS

_RECORDING_DEPTH = 4000
"""Samples a topic may wait for the recorder: 20 s at 200 Hz."""
_REPLAY_DEPTH = 1000
"""Samples a slow reliable subscriber may lag behind the player."""


class TopicSelection:
    """Topics named by patterns such as `wheel_states`, `*/slip` or `/truth/*`."""

    def __init__(self, include: Sequence[str] = (), exclude: Sequence[str] = (), namespace: str = "/") -> None:
        """Take patterns.

        Args:
            include: patterns of topics to select; none for all.
            exclude: patterns of topics to leave out.
            namespace: namespace of patterns without a leading slash.
        """
        self._include = [_absolute(pattern, namespace) for pattern in include]
        self._exclude = [_absolute(pattern, namespace) for pattern in exclude]

    def wants(self, name: str) -> bool:
        """Whether the absolute name is selected."""
        if any(fnmatchcase(name, pattern) for pattern in self._exclude):
            return False
        return not self._include or any(fnmatchcase(name, pattern) for pattern in self._include)

    def is_complete(self, names: Collection[str]) -> bool:
        """Whether every selected topic is among these absolute names; always False with a wildcard."""
        return bool(self._include) and set(self._include) <= set(names)


def add_selection_arguments(parser: ArgumentParser) -> None:
    """Add the options that select topics."""
    parser.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="only these, such as '*/slip'")
    parser.add_argument("--exclude", nargs="+", default=[], metavar="TOPIC", help="not these")


def selection_of(args: Namespace, namespace: str = "/") -> TopicSelection:
    """Return the selection by the options."""
    return TopicSelection(args.topics, args.exclude, namespace)


def stored(profile: QoSProfile) -> Qos:
    """Return the form in which a bag stores a profile."""
    return Qos(
        QosHistory(int(profile.history)),
        profile.depth,
        QosReliability(int(profile.reliability)),
        QosDurability(int(profile.durability)),
        _time(profile.deadline),
        _time(profile.lifespan),
        QosLiveliness(int(profile.liveliness)),
        _time(profile.liveliness_lease_duration),
        bool(profile.avoid_ros_namespace_conventions),
    )


def matching(publishers: Sequence[TopicEndpointInfo]) -> QoSProfile:
    """Return the strictest profile that all publishers match: reliable and transient local only where they all are."""
    offered = [publisher.qos_profile for publisher in publishers]
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    return _profile(_RECORDING_DEPTH, reliable=reliable, latched=latched)


def replayed(recorded: Sequence[Qos]) -> QoSProfile:
    """Return the profile of the player: reliable, which every subscriber matches; transient local where it was."""
    latched = bool(recorded) and all(qos.durability == QosDurability.TRANSIENT_LOCAL for qos in recorded)
    depth = max(max(qos.depth for qos in recorded), 1) if latched else _REPLAY_DEPTH
    return _profile(depth, reliable=True, latched=latched)


def _absolute(pattern: str, namespace: str) -> str:
    return pattern if pattern.startswith("/") else f"{namespace.rstrip('/')}/{pattern}"


def _profile(depth: int, *, reliable: bool, latched: bool) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def _time(duration: Duration) -> QosTime:
    return QosTime(*divmod(int(duration.nanoseconds), NANOSECONDS))
