"""Faults of clocks: stamps that repeat, are zero, crawl or jump."""

from collections.abc import Callable, Collection, Sequence
from typing import Any

from campaigns.faults.fault import Arrival, Fault, Site, at_once
from friction_runtime.stamps import header_at, to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

_CRAWL = 1_000
"""Nanoseconds of stamps for a second: they pass as new ones."""


def _restamped(topics: Collection[str], stamp: Callable[[int, int], int]) -> Fault:
    """`stamp` makes the new stamp of the first one since the begin of the fault, and the present one [ns]."""
    first: dict[str, int] = {}

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic in topics:
            now = to_nanoseconds(message.header.stamp)
            # a header of its own: messages of one sender share theirs
            message.header = header_at(stamp(first.setdefault(topic, now), now), message.header.frame_id)
        return at_once(topic, message)

    return pass_on


def repeating(topics: Collection[str]) -> Fault:
    """The values go on under one stamp."""
    return _restamped(topics, lambda first, now: first)


def zero(topics: Collection[str]) -> Fault:
    """No stamp is set."""
    return _restamped(topics, lambda first, now: 0)


def crawling(topics: Collection[str]) -> Fault:
    """Stamps grow by a millionth of the time that passes."""
    return _restamped(topics, lambda first, now: first + (now - first) * _CRAWL // NANOSECONDS)


def shifted(topics: Collection[str], seconds: float) -> Fault:
    """The clock of these topics jumps once and goes on from there."""
    return _restamped(topics, lambda first, now: now + round(seconds * NANOSECONDS))


def clock_jump(site: Site, topics: Collection[str], seconds: float) -> Fault:
    """The clock of the car jumps: that of all sensors, and that of the brake, which compares commands with it."""
    sensors = shifted(topics, seconds)
    brake = shifted([f"{wheel}/brake_command" for wheel in site.vehicle.wheel_names], -seconds)

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        return brake(topic, message) if topic.endswith("/brake_command") else sensors(topic, message)

    return pass_on
