"""The best that a brake can do: its full rate until the slip reaches lambda_max, and mu_max from there on."""

from dataclasses import dataclass

import numpy as np

from benchmarks.closed_loop.panic_plant import PanicPlant
from benchmarks.closed_loop.panic_stop import END_SPEED
from benchmarks.closed_loop.trouble import Trouble
from benchmarks.protocol import SPEED
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import Command


@dataclass(frozen=True)
class ActuatorBound:
    """Of one plant; no law is better but by luck."""

    utilisation: float
    """To END_SPEED [-]."""
    utilisation_to_rest: float
    """[-]"""
    distance: float
    """To standstill [m]."""
    longest_lock: float = 0.0
    """[s] where the road changes: what no release comes in time for."""


def actuator_bound(surface: str, trouble: Trouble) -> ActuatorBound:
    """Return the bound of a plant on a road of one surface; a load that varies does not count."""
    plant = PanicPlant(surface, trouble.steady, np.zeros((1, 1)))
    corner = plant.corner
    lambda_max = float(burckhardt.peak(plant.theta)[0][0])
    increase = np.array([int(Command.INCREASE)])
    while corner.slip[0] < lambda_max and corner.speed[0] > END_SPEED:
        plant.advance(plant.demand, increase)
    best, time = float(plant.best_deceleration[0]), plant.since
    speed = float(corner.speed[0])
    to_end, to_rest = time + (speed - END_SPEED) / best, time + speed / best
    return ActuatorBound(
        (SPEED - END_SPEED) / (best * to_end),
        SPEED / (best * to_rest),
        float(corner.distance[0]) + speed**2 / (2.0 * best),
    )
