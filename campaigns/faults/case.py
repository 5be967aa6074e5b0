"""Faults between plant and graph; manoeuvres and cases of the campaign: car, surface, demand, time and limits."""

from collections import deque
from collections.abc import Callable, Collection, Sequence
from copy import deepcopy
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import Any, NamedTuple

import numpy as np

from benchmarks.protocol import ACCELERATION_STDDEV, SPEED
from corner_sim.car_plant import CAR, in_order
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle


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
        return self.topics("brake_pressure")

    def topics(self, name: str, wheels: int | None = None) -> tuple[str, ...]:
        """Topics of this name of the first wheels, or of all."""
        return tuple(f"{wheel}/{name}" for wheel in self.vehicle.wheel_names[:wheels])


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


def keeping() -> Callable[[float], float]:
    """Return what a sensor reads that keeps the first value it is given."""
    first: list[float] = []

    def read(value: float) -> float:
        first.append(value)
        return first[0]

    return read


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


ONSET = 1.0
"""The driver brakes after so long of free rolling [s]: by then every node knows that its inputs can be relied upon."""
CORNER, FOUR_WHEELS = "corner", "four_wheels"
_VEHICLES = {CORNER: "chapter_corner", FOUR_WHEELS: "compact_car"}
_MODELS = {CORNER: "single_corner", FOUR_WHEELS: CAR}
START = 10_000 * NANOSECONDS
"""Stamp of the first sample: late enough for stamps an hour older."""


@dataclass(frozen=True)
class Manoeuvre:
    """A stop. The corner has a speed sensor, as in the chapter; the car with four wheels has none."""

    car: str
    """CORNER or FOUR_WHEELS."""
    surface: str
    demand: float
    """In units of the peak torque of the first wheel."""

    @property
    def vehicle(self) -> Vehicle:
        """The car, its wheels in the order of wheel_states."""
        vehicle = load_vehicle(_VEHICLES[self.car])
        return in_order(vehicle) if self.car == FOUR_WHEELS else vehicle

    def simulation(self, seed: int) -> Simulation:
        """Return the plant at its first sample."""
        parameters = SimParameters(
            model=_MODELS[self.car],
            initial_speed=SPEED,
            surfaces=(self.surface,),
            demand_level=self.demand,
            demand_start=ONSET,
            acceleration_variance=ACCELERATION_STDDEV**2,
            seed=seed,
            vehicle_velocity=self.car == CORNER,
        )
        return Simulation(parameters, self.vehicle, START)


class Hit(Enum):
    """Whose ABS the fault may cost."""

    NO_WHEEL = "no wheel"
    FIRST_WHEEL = "the first wheel"
    ALL_WHEELS = "all wheels"


FROM_START = -ONSET
"""Begin of a fault that is always there [s since the onset]."""
BEFORE_BRAKING = -0.25
"""Begin of a fault that comes before the brake [s since the onset]."""
IN_BRAKING = 0.5
"""Begin of a fault that comes while the car brakes [s since the onset]."""


@dataclass(frozen=True)
class Case:
    """A fault from `begin` to `end` [s since the onset of braking]."""

    name: str
    make: Callable[[Site], Fault]
    hit: Hit = Hit.NO_WHEEL
    begin: float = IN_BRAKING
    end: float = inf
    none_within: float = inf
    """[s] from the last good message to NONE at every wheel that is hit."""
    none_later: float = 0.0
    """[s] more for that at a demand above the peak torque, where the ABS must first see what a release does."""
    named_within: float = inf
    """[s] from the begin, or from the onset where that is later, to a reason or diagnostics above OK."""
    named: str = ""
    """What the text must contain in which the fault is named."""
    stretch: float = inf
    """Longest distance over that of the same stop without fault."""
    wrong_for: float = inf
    """[s] longest time for which a valid slip is wrong."""
