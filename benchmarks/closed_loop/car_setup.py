"""Cars with four wheels under full braking, and the nominal parameters of their graph."""

from dataclasses import dataclass, replace

import numpy as np

from abs_supervisor.wheel_pair import NO_AXLE
from benchmarks.closed_loop.law_stops import OFFSET, ROLLING
from benchmarks.closed_loop.panic_plant import DEMAND_RATIO
from benchmarks.closed_loop.panic_road import panic_road
from benchmarks.closed_loop.trouble import NONE, Trouble
from benchmarks.protocol import ACCELERATION_STDDEV, DT, SPEED
from corner_sim.car_model import SAME, CarModelParameters
from corner_sim.models import CAR, in_order
from corner_sim.parameters import SimParameters
from corner_sim.road import Road
from corner_sim.simulation import Simulation
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.surfaces import surface
from vehicle_models.two_axle import peak_torque
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

MODELS = {"four_wheels": "two_axle", "car": CAR}
"""Models of corner_sim by the names of the rows."""
SHIPPED_CAR = "compact_car"
_ROLLED = SPEED * ROLLING * DT
"""[m] before the onset; less what the drag takes."""
_HILL = _ROLLED + 15.0
"""[m] Where a hill begins."""
_START = 10_000 * NANOSECONDS
"""Stamp of the first sample."""


@dataclass(frozen=True)
class CarSetup:
    """A car on one road, without speed sensor, braked with the full demand after ROLLING samples."""

    car: str
    """Of MODELS."""
    surface: str
    """Name of a road, which panic_road knows."""
    trouble: Trouble = NONE
    right_surface: str = SAME
    """Of the right wheels; only with the car whose model is CAR."""
    select_low: str = NO_AXLE
    """Axle whose wheels get the same pressure."""
    yaw_moment_rate: float = 0.0
    """Fastest growth of the moment of the front brakes [N m/s]; 0: no limit."""

    @property
    def told(self) -> Vehicle:
        """The car as the graph knows it, wheels in the order of the plant."""
        car = replace(load_vehicle(SHIPPED_CAR), front_yaw_moment_rate=self.yaw_moment_rate)
        return in_order(MODELS[self.car], car)

    @property
    def vehicle(self) -> Vehicle:
        """The car that brakes."""
        return self.trouble.vehicle(self.told)

    @property
    def road(self) -> Road:
        """Surfaces from where the run starts on; one that changes does so soon after the onset of braking."""
        way = panic_road(self.surface)
        return Road(way.names, [distance + _ROLLED * (distance > 0.0) for distance in way.distances])

    @property
    def demand(self) -> float:
        """DEMAND_RATIO times the pressure [Pa] at which the wheel with the weakest brake for its load has its peak.

        On the surface of the way where that is highest.
        """
        car = self.vehicle
        gains = np.array([wheel.brake_gain for wheel in car.wheels])
        torques = [peak_torque(car, surface(name)) for name in self.road.names]
        return DEMAND_RATIO * float(np.max(torques / gains))

    @property
    def parameters(self) -> SimParameters:
        """Those of the plant."""
        return SimParameters(
            model=MODELS[self.car],
            initial_speed=SPEED,
            surfaces=self.road.names,
            surface_distances=self.road.distances,
            demand_unit="torque",
            demand_level=self.demand * self.vehicle.wheels[0].brake_gain,
            demand_start=ROLLING * DT,
            acceleration_variance=ACCELERATION_STDDEV**2,
            acceleration_offset=OFFSET,
            vehicle_velocity=False,
            actuator=self.trouble.actuator,
            car=CarModelParameters(right_surface=self.right_surface, hill=self.trouble.hill, hill_distance=_HILL),
        )

    def simulation(self, seed: int) -> Simulation:
        """Return the plant at its first sample."""
        return Simulation(replace(self.parameters, seed=seed), self.vehicle, _START)
