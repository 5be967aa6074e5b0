"""Faults of one topic, whatever it carries: a wrong value, silence, a sender that repeats itself."""

from collections import deque
from collections.abc import Callable, Collection, Sequence
from copy import deepcopy
from typing import Any

from campaigns.faults.fault import Arrival, Fault, at_once


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
