"""Corners on one road that roll freely and are then braked harder than the road allows."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.closed_loop.panic_road import panic_road
from benchmarks.closed_loop.trouble import Trouble
from benchmarks.protocol import CORNER, DT, SPEED
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.single_corner import CornerParameters, SingleCorner

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Commands = NDArray[np.int64]

DEMAND_RATIO = 1.5
"""Demand in units of the peak torque."""


@dataclass
class PanicPlant:
    """n corners on one road; at the start they roll freely at SPEED."""

    surface: str
    """Name of the road, which panic_road knows."""
    trouble: Trouble
    phases: Array
    """Phases of the wheel load [rad], shape (n, tones)."""
    told: CornerParameters = CORNER
    """The corner without the trouble."""
    corner: SingleCorner = field(init=False)
    torque: Array = field(init=False)
    """That acts [N m], shape (n,)."""
    demand: float = field(init=False)
    """DEMAND_RATIO of the highest peak torque of the way [N m by the vehicle file]."""
    since: float = field(init=False, default=0.0)
    """Time since the onset of braking [s]."""

    def __post_init__(self) -> None:
        """Start at full speed."""
        count = len(self.phases)
        trouble = self.trouble
        self.parameters = trouble.corner(self.told)
        self.way = panic_road(self.surface)
        self.corner = SingleCorner(self.parameters, np.full(count, SPEED))
        peaks = self.parameters.peak_torque(self.way.theta(np.array(self.way.distances)))
        self.demand = DEMAND_RATIO * float(np.max(peaks)) / trouble.gain
        self.actuator = BrakeActuator(count, DT, trouble.actuator)
        self.torque = np.zeros(count)
        self.time = 0.0
        self._onset = self.corner.distance

    @property
    def braked_way(self) -> Array:
        """Way since the onset of braking [m], shape (n,)."""
        return self.corner.distance - self._onset

    @property
    def theta(self) -> Array:
        """Burckhardt parameters under the wheels now, shape (n, 3)."""
        return self.way.theta(self.braked_way)

    @property
    def mu_max(self) -> Array:
        """Of the road under the wheels now [-], shape (n,)."""
        return np.asarray(burckhardt.peak(self.theta)[1])

    def road(self) -> Array:
        """Curves now, the wheel load in them, shape (n, 3)."""
        load = self.trouble.load_at(self.time, self.phases)
        theta = self.theta.copy()
        theta[:, 0] *= load
        theta[:, 2] *= load
        return theta

    @property
    def best_deceleration(self) -> Array:
        """At mu_max [m/s^2], shape (n,)."""
        return self.mu_max * self.parameters.gravity

    @property
    def gain(self) -> float:
        """Brake torque over that of the vehicle file now [-]."""
        return self.trouble.gain_at(self.since)

    @property
    def acceleration(self) -> Array:
        """Of the car [m/s^2], shape (n,)."""
        return self.corner.acceleration(self.road())

    def advance(self, demand: float, commands: Commands) -> None:
        """Advance by a sample under a demand [N m by the vehicle file], 0: not braked, and commands, shape (n,)."""
        if demand > 0.0:
            self.since += DT
        else:
            self._onset = self.corner.distance
        after = self.actuator.step(demand, commands) * self.gain
        self.corner.step(self.torque, after, self.road(), DT)
        self.torque = after
        self.time += DT
