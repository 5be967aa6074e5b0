"""Faults of the way that messages take: late, lost, twice, in another order, and from two senders."""

from collections.abc import Collection, Sequence
from copy import deepcopy
from typing import Any

from benchmarks.protocol import DT
from campaigns.faults.fault import Arrival, Fault, Site, at_once
from friction_runtime.stamps import from_nanoseconds, to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES
from vehicle_models.nanoseconds import NANOSECONDS

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
