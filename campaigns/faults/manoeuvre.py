"""Manoeuvre: a car, a surface and a demand, from 30 m/s to standstill."""

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.protocol import ACCELERATION_STDDEV, SPEED
from corner_sim.models import in_order
from corner_sim.parameters import SimParameters
from corner_sim.plant import PlantSample
from corner_sim.simulation import Simulation
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

ONSET = 1.0
"""The driver brakes after so long of free rolling [s]: by then every node knows that its inputs can be relied upon."""
CORNER, FOUR_WHEELS = "corner", "four_wheels"
_VEHICLES = {CORNER: "chapter_corner", FOUR_WHEELS: "compact_car"}
_MODELS = {CORNER: "single_corner", FOUR_WHEELS: "two_axle"}
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
        return in_order(_MODELS[self.car], load_vehicle(_VEHICLES[self.car]))

    def simulation(self, seed: int, recorded: Sequence[PlantSample] = ()) -> Simulation:
        """Return the plant at its first sample; `recorded` are the samples of this stop without commands."""
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
        return Simulation(parameters, self.vehicle, _START, recorded)
