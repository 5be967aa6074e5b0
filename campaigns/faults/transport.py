"""Faults of stamps and of the transport, and nodes that are gone."""

from collections.abc import Callable, Collection, Sequence
from copy import deepcopy
from typing import Any

from friction_msgs.msg import Validity

from benchmarks.protocol import DT
from campaigns.faults.case import Arrival, Fault, Site, at_once, changed, silent
from friction_runtime.messages import from_nanoseconds, header_at, to_nanoseconds
from friction_runtime.wheel_inputs import WHEEL_STATES
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
    brake = shifted(site.topics("brake_command"), -seconds)

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        return brake(topic, message) if topic.endswith("/brake_command") else sensors(topic, message)

    return pass_on


_HOUR = 3600 * NANOSECONDS
_OTHER_SPEED = 20.0
"""[m/s] of the other car, which rolls freely."""


def late(site: Site, topics: Collection[str], share: float, delay: float) -> Fault:
    """A share of the messages of each topic comes late by a delay [s]."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        return [Arrival(delay if topic in topics and site.random.random() < share else 0.0, topic, message)]

    return pass_on


def reordered(site: Site, topics: Collection[str], share: float) -> Fault:
    """A share of the messages comes after the next one of its topic."""
    return late(site, topics, share, 1.5 * DT)


def dropped(site: Site, topics: Collection[str], share: float) -> Fault:
    """A share of the messages does not come."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        return () if topic in topics and site.random.random() < share else at_once(topic, message)

    return pass_on


def duplicated(site: Site, topics: Collection[str], share: float) -> Fault:
    """A share of the messages comes twice."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        twice = topic in topics and site.random.random() < share
        return [Arrival(0.0, topic, deepcopy(message)) for _ in range(1 + twice)]

    return pass_on


def replayed_beside(site: Site) -> Fault:
    """A bag of an hour ago, of a car that rolls freely, is replayed on wheel_states beside the car's own."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic != WHEEL_STATES:
            return at_once(topic, message)
        other = deepcopy(message)
        other.header.stamp = from_nanoseconds(to_nanoseconds(message.header.stamp) - _HOUR)
        for place, wheel in enumerate(site.vehicle.wheels):
            other.velocity[place] = _OTHER_SPEED / wheel.radius
        return [*at_once(topic, message), *at_once(topic, other)]

    return pass_on


def second_demand(site: Site) -> Fault:
    """Another sender says on brake_demand, half a sample later, that nobody brakes."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic != "brake_demand":
            return at_once(topic, message)
        other = deepcopy(message)
        other.header.stamp = from_nanoseconds(to_nanoseconds(message.header.stamp) + round(0.5 * DT * NANOSECONDS))
        other.pressure = 0.0
        return [*at_once(topic, message), *at_once(topic, other)]

    return pass_on


_WORST_INDICATOR = -1e5
"""[rad/s^3] Calls for a release wherever validity is not looked at."""


def lost(site: Site, name: str) -> Fault:
    """The topic `name` of every wheel does not come."""
    return silent(site.topics(name))


def invalid_slope(site: Site) -> Fault:
    """The vote of the first wheel says that it does not count, beside an indicator that calls for a release."""

    def change(message: Any) -> None:
        message.validity = Validity(reason=Validity.BAD_INPUT, text="injected")
        message.indicator = _WORST_INDICATOR

    return changed((f"{site.wheel}/slope_vote",), change)
