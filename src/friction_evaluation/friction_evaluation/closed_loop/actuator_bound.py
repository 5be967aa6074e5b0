"""The best that a brake can do: its full rate until the slip reaches lambda_max, and mu_max from there on."""

from dataclasses import dataclass

import numpy as np

from friction_evaluation.closed_loop.panic_stop import END_SPEED, PanicPlant
from friction_evaluation.closed_loop.trouble import Trouble
from friction_evaluation.protocol import DT, SPEED
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


def actuator_bound(surface: str, trouble: Trouble) -> ActuatorBound:
    """Return the bound of a plant on a road; a load that varies does not count."""
    steady = Trouble(**{**trouble.__dict__, "load_variation": 0.0})
    plant = PanicPlant(surface, steady, np.zeros((1, 1)))
    corner = plant.corner
    lambda_max, mu_max = (float(value) for value in burckhardt.peak(plant.theta))
    increase = np.array([int(Command.INCREASE)])
    time = 0.0
    while corner.slip[0] < lambda_max and corner.speed[0] > END_SPEED:
        plant.brake(increase, time)
        time += DT
    best = mu_max * steady.corner.gravity
    speed = float(corner.speed[0])
    to_end, to_rest = time + (speed - END_SPEED) / best, time + speed / best
    return ActuatorBound(
        (SPEED - END_SPEED) / (best * to_end),
        SPEED / (best * to_rest),
        float(corner.distance[0]) + speed**2 / (2.0 * best),
    )
