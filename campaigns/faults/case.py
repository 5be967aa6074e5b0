"""Manoeuvres and cases of the fault campaign: car, surface, demand; fault, time and limits."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import inf

from benchmarks.protocol import ACCELERATION_STDDEV, SPEED
from campaigns.faults.fault import Fault, Site
from corner_sim.car_plant import CAR, in_order
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

ONSET = 1.0
"""The driver brakes after so long of free rolling [s]: by then every node knows that its inputs can be relied upon."""
CORNER, FOUR_WHEELS = "corner", "four_wheels"
_VEHICLES = {CORNER: "chapter_corner", FOUR_WHEELS: "compact_car"}
_MODELS = {CORNER: "single_corner", FOUR_WHEELS: CAR}
_START = 10_000 * NANOSECONDS
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
        return Simulation(parameters, self.vehicle, _START)


class Hit(Enum):
    """Whose ABS the fault may cost."""

    NO_WHEEL = "no wheel"
    FIRST_WHEEL = "the first wheel"
    ALL_WHEELS = "all wheels"


BEFORE_BRAKING = -0.25
"""Begin of a fault that is there before the brake [s since the onset]."""
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
