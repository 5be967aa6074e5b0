"""Fault injection between plant and graph: messages in, messages out."""

from collections.abc import Callable, Sequence
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
