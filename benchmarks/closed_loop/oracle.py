"""The law with everything known: true curve, speeds and torque, no envelope. What is lost beyond it is estimation."""

import numpy as np

from abs_supervisor.law.curve_law import CurveLaw, CurveLawParameters
from abs_supervisor.law.road_curve import RoadCurve
from abs_supervisor.law.usable_curve import CurveReport, Estimate
from benchmarks.closed_loop.panic_plant import Commands, Flags, PanicPlant
from benchmarks.closed_loop.panic_stop import PanicStops, brake_to_rest
from benchmarks.closed_loop.trouble import Trouble
from benchmarks.protocol import STEP
from vehicle_models import burckhardt
from vehicle_models.brake_actuator import Command

_SEEN = 3
"""Valid reports after which the law takes the peak as seen."""


def oracle(surface: str, trouble: Trouble) -> PanicStops:
    """Return the stop of the oracle, arrays of shape (1,); a load that varies does not count."""
    plant = PanicPlant(surface, trouble.steady, np.zeros((1, 1)))
    corner = plant.corner
    law = CurveLaw(plant.parameters, trouble.actuator, CurveLawParameters())
    thetas = plant.way.theta(np.array(plant.way.distances))
    values = np.column_stack((thetas, burckhardt.peak(thetas)[0])).tolist()
    curves = [RoadCurve(theta_1, theta_2, theta_3, peak) for theta_1, theta_2, theta_3, peak in values]

    def brake(running: Flags) -> Commands:
        stamp = round(plant.since * 1e9) + STEP
        now = int(plant.way.index(plant.braked_way)[0])
        for _ in range(_SEEN):
            # A fit of its own for each sample: what is known leaves no torque unexplained.
            law.learn(CurveReport(stamp, Estimate.VALID, curves[now], 0.0, 0.0, 1000, stamp))
        speed = float(corner.speed[0])
        demand = plant.demand * plant.gain
        asked = law.ask(
            stamp,
            float(corner.wheel_speed[0]),
            speed,
            float(corner.slip[0]),
            float(plant.torque[0]),
            demand,
            True,
        )
        given = Command.NONE if asked is None else asked
        law.commanded(stamp, given, demand)
        commands = np.array([int(given)])
        plant.advance(plant.demand, commands)
        return commands

    return brake_to_rest(plant, brake)
