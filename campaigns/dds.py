"""Messages taken from a subscription without an executor, and memory, threads and descriptors of a process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
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


@dataclass(frozen=True)
class ProcessUse:
    """What a process holds at one time."""

    rss: int
    """Resident memory [B]."""
    threads: int
    descriptors: int


def use_of(process: int) -> ProcessUse:
    """Return what the process with this id holds.

    Raises:
        OSError: there is no such process, or it is another user's.
    """
    directory = Path("/proc", str(process))
    lines = (directory / "status").read_text(encoding="ascii", errors="replace").splitlines()
    fields = dict(line.split(":", 1) for line in lines)
    rss = int(fields.get("VmRSS", "0 kB").split()[0]) * 1024  # one that ends has none any more
    return ProcessUse(rss, int(fields["Threads"]), len(list((directory / "fd").iterdir())))
