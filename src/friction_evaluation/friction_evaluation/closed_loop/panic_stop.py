"""What a stop from full speed to standstill gives, whoever commands the brake."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_evaluation.closed_loop.trouble import Trouble
from friction_evaluation.protocol import DT, SPEED
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.single_corner import SingleCorner
from vehicle_models.surfaces import surface

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Commands = NDArray[np.int64]

DEMAND_RATIO = 1.5
"""Demand in units of the peak torque of the car that the graph is told of."""
END_SPEED = 5.0
"""[m/s] first end of a stop."""
LOCK_ABOVE = 1.5
"""[m/s] below it the driver has the brake, and a lock does not count."""
_LOCK_SLIP = 0.95
_LONGEST = 60.0
"""[s] after which a run is given up."""


@dataclass
class PanicStops:
    """Results of n stops, arrays of shape (n,)."""

    utilisation: Array
    """Deceleration over that at mu_max, from the onset to END_SPEED [-]."""
    utilisation_to_rest: Array
    """To standstill [-]."""
    distance: Array
    """From the onset to standstill [m]."""
    longest_lock: Array
    """[s] above LOCK_ABOVE."""
    changes: Array
    """Changes of the command in a second, above END_SPEED [1/s]."""
    stopped: Flags
    """Came to rest, and stayed."""


@dataclass
class PanicPlant:
    """n corners on one road, rolling freely, then braked with DEMAND_RATIO."""

    surface: str
    trouble: Trouble
    phases: Array
    """Phases of the wheel load [rad], shape (n, tones)."""
    corner: SingleCorner = field(init=False)
    torque: Array = field(init=False)
    """That acts [N m], shape (n,)."""
    demand: float = field(init=False)
    """Of the driver [N m by the vehicle file]."""

    def __post_init__(self) -> None:
        """Start at full speed."""
        count = len(self.phases)
        trouble = self.trouble
        self.theta = np.asarray(surface(self.surface), dtype=np.float64)
        self.corner = SingleCorner(trouble.corner, np.full(count, SPEED))
        self.mu_max = float(burckhardt.peak(self.theta)[1])
        self.demand = DEMAND_RATIO * float(trouble.corner.peak_torque(self.theta)) / trouble.gain
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
    def acceleration(self) -> Array:
        """Of the car [m/s^2], shape (n,)."""
        return self.corner.acceleration(self.road())

    def roll(self) -> None:
        """Advance by a sample without brake."""
        self.corner.step(0.0, 0.0, self.road(), DT)
        self.time += DT

    def brake(self, commands: Commands, since: float) -> None:
        """Advance by a sample under commands, shape (n,), `since` the onset [s]."""
        after = self.actuator.step(self.demand, commands) * self.trouble.gain_at(since + DT)
        self.corner.step(self.torque, after, self.road(), DT)
        self.torque = after
        self.time += DT


def brake_to_rest(plant: PanicPlant, command: Callable[[float, Flags], Commands]) -> PanicStops:
    """Brake all corners of a plant to standstill.

    Args:
        plant: before the onset.
        command: returns the commands, shape (n,), for the time since the onset [s] and for the corners that still run.
    """
    corner = plant.corner
    count = corner.speed.size
    start, speed = corner.distance, corner.speed.copy()
    begin_speed = speed.copy()
    end_time, end_share = np.full(count, np.nan), np.full(count, np.nan)
    rest_time = np.full(count, np.nan)
    lock, longest, changes = np.zeros(count), np.zeros(count), np.zeros(count)
    before: Commands = np.ones(count, dtype=np.int64)
    running: Flags = np.ones(count, dtype=bool)
    since = 0.0
    while running.any() and since < _LONGEST:
        given = command(since, running)
        changes += running & (given != before) & (speed > END_SPEED)
        before = given
        plant.brake(given, since)
        now = corner.speed
        crossed = (speed > END_SPEED) & (now <= END_SPEED)
        share = (speed - END_SPEED) / np.maximum(speed - now, 1e-12)
        end_time = np.where(crossed, since + DT * share, end_time)
        end_share = np.where(crossed, 1.0, end_share)
        lock = np.where(running & (corner.slip > _LOCK_SLIP) & (now > LOCK_ABOVE), lock + DT, 0.0)
        longest = np.maximum(longest, lock)
        since += DT
        ended = running & (now <= 0.0)
        rest_time = np.where(ended, since, rest_time)
        running = running & ~ended
        speed = now.copy()
    best = plant.mu_max * plant.trouble.corner.gravity
    return PanicStops(
        utilisation=(begin_speed - END_SPEED) / (best * end_time),
        utilisation_to_rest=begin_speed / (best * rest_time),
        distance=corner.distance - start,
        longest_lock=longest,
        changes=changes / end_time,
        stopped=np.isfinite(rest_time) & (corner.speed <= 0.0),
    )
