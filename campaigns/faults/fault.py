"""Fault injection between plant and graph: messages in, messages out."""

from collections import deque
from collections.abc import Callable, Collection, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vehicle_models.vehicle import Vehicle


class Arrival(NamedTuple):
    """A message that arrives."""

    delay: float
    """[s] after it was sent, >= 0."""
    topic: str
    """Relative name."""
    message: Any


Fault = Callable[[str, Any], Sequence[Arrival]]
"""Takes each message that is sent, by topic, from the begin of the fault on; returns what arrives of it. It may change
the message: nobody else holds it."""


@dataclass(frozen=True)
class Site:
    """Where a fault acts, and its chance."""

    vehicle: Vehicle
    """Wheels in the order of wheel_states; the first one has the faults of one wheel."""
    random: np.random.Generator

    @property
    def wheel(self) -> str:
        """The wheel that has the faults of one wheel."""
        return self.vehicle.wheel_names[0]

    @property
    def pressures(self) -> tuple[str, ...]:
        """Topics of the pressures."""
        return tuple(f"{wheel}/brake_pressure" for wheel in self.vehicle.wheel_names)


def at_once(topic: str, message: Any) -> list[Arrival]:
    """Return the message as it is: the fault of a graph without fault."""
    return [Arrival(0.0, topic, message)]


def changed(topics: Collection[str], change: Callable[[Any], None]) -> Fault:
    """Every message of these topics is changed."""

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic in topics:
            change(message)
        return at_once(topic, message)

    return pass_on


def constant(topics: Collection[str], field: str, value: float) -> Fault:
    """A field of the messages has always this value, under stamps that go on."""
    return changed(topics, lambda message: setattr(message, field, value))


def scaled(topics: Collection[str], field: str, factor: float) -> Fault:
    """A field of the messages shows a multiple of what is true."""
    return changed(topics, lambda message: setattr(message, field, factor * getattr(message, field)))


def silent(topics: Collection[str]) -> Fault:
    """Nothing comes any more."""
    return lambda topic, message: () if topic in topics else at_once(topic, message)


def frozen(topics: Collection[str]) -> Fault:
    """The sender repeats its first message, stamp and all."""
    first: dict[str, Any] = {}

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic not in topics:
            return at_once(topic, message)
        return at_once(topic, deepcopy(first.setdefault(topic, message)))

    return pass_on


def lagging(topics: Collection[str], field: str, samples: int) -> Fault:
    """A field shows what was true so many samples before, under the present stamp."""
    past: dict[str, deque[float]] = {}

    def pass_on(topic: str, message: Any) -> Sequence[Arrival]:
        if topic in topics:
            line = past.setdefault(topic, deque(maxlen=samples + 1))
            line.append(getattr(message, field))
            setattr(message, field, line[0])
        return at_once(topic, message)

    return pass_on
