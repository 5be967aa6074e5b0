"""Corners on one road that roll freely and are then braked harder than the road allows."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_evaluation.closed_loop.trouble import Trouble
from friction_evaluation.protocol import CORNER, DT, SPEED
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.single_corner import CornerParameters, SingleCorner
from vehicle_models.surfaces import surface

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Commands = NDArray[np.int64]

DEMAND_RATIO = 1.5
"""Demand in units of the peak torque."""


@dataclass
class PanicPlant:
    """n corners on one road; at the start they roll freely at SPEED."""

    surface: str
    trouble: Trouble
    phases: Array
    """Phases of the wheel load [rad], shape (n, tones)."""
    told: CornerParameters = CORNER
    """The corner without the trouble."""
    corner: SingleCorner = field(init=False)
    torque: Array = field(init=False)
    """That acts [N m], shape (n,)."""
    demand: float = field(init=False)
    """DEMAND_RATIO of the driver [N m by the vehicle file]."""
    since: float = field(init=False, default=0.0)
    """Time since the onset of braking [s]."""

    def __post_init__(self) -> None:
        """Start at full speed."""
        count = len(self.phases)
        trouble = self.trouble
        self.parameters = trouble.corner(self.told)
        self.theta = np.asarray(surface(self.surface), dtype=np.float64)
        self.corner = SingleCorner(self.parameters, np.full(count, SPEED))
        self.mu_max = float(burckhardt.peak(self.theta)[1])
        self.demand = DEMAND_RATIO * float(self.parameters.peak_torque(self.theta)) / trouble.gain
        self.actuator = BrakeActuator(count, DT, trouble.actuator)
        self.torque = np.zeros(count)
        self.time = 0.0

    def road(self) -> Array:
        """Curves now, the wheel load in them, shape (n, 3)."""
        load = self.trouble.load_at(self.time, self.phases)
        theta = np.repeat(self.theta[np.newaxis], len(load), axis=0)
        theta[:, 0] *= load
        theta[:, 2] *= load
        return theta

    @property
    def best_deceleration(self) -> float:
        """At mu_max [m/s^2]."""
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
        after = self.actuator.step(demand, commands) * self.gain
        self.corner.step(self.torque, after, self.road(), DT)
        self.torque = after
        self.time += DT
