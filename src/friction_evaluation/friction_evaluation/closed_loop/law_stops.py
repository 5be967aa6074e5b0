"""Stops of one corner with the graph in the loop, as the issue of the law asks for: no speed sensor, an accelerometer
with offset and noise.
"""

from dataclasses import replace

import numpy as np

from abs_supervisor.parameters import SHIPPED as SHIPPED_SUPERVISOR
from corner_sim.sensors import Measurement
from friction_evaluation.closed_loop.controller import Controller
from friction_evaluation.closed_loop.panic_stop import Commands, Flags, PanicPlant, PanicStops, brake_to_rest
from friction_evaluation.closed_loop.trouble import Trouble
from friction_evaluation.protocol import ACCELERATION_STDDEV, BRAKE_GAIN, CAR, DT, STEP
from friction_slope.parameters import SHIPPED as SHIPPED_SLOPE

OFFSET = 0.15
"""Of the accelerometer [m/s^2]."""
_ROLLING = round(3.0 / DT)
"""Samples of free rolling before the brake, in which wheel_slip learns the offset of the accelerometer."""


def law_stops(surface: str, seeds: range, law: str, trouble: Trouble) -> PanicStops:
    """Brake once for each seed, side by side.

    Args:
        surface: its name.
        seeds: of the sensor noise and the road's roughness.
        law: of abs_supervisor.
        trouble: what the graph is not told of.
    """
    supervisor = replace(SHIPPED_SUPERVISOR["abs_supervisor"].parameters, shadow=False, real_time=False, law=law)
    slope = SHIPPED_SLOPE["friction_slope"].parameters
    noise = trouble.sensors
    controllers = [Controller(CAR, noise, slope, supervisor, speed_sensor=False) for _ in seeds]
    generators = [np.random.default_rng(seed) for seed in seeds]
    of_accelerometer = [np.random.default_rng((seed, 2)) for seed in seeds]
    phases = np.array([Trouble.phases(np.random.default_rng((seed, 3))) for seed in seeds])
    plant = PanicPlant(surface, trouble, phases)
    samples = 0

    def sense(demand: float, gain: float, running: Flags) -> Commands:
        nonlocal samples
        samples += 1
        commands = np.zeros(len(seeds), dtype=np.int64)
        acceleration = plant.acceleration
        for i in np.flatnonzero(running).tolist():
            draw = generators[i].standard_normal(2)
            speed = plant.corner.wheel_speed[i] + np.sqrt(noise.wheel_speed_variance) * draw[0]
            torque = plant.torque[i] / gain + np.sqrt(noise.torque_variance) * draw[1]
            error = OFFSET + ACCELERATION_STDDEV * of_accelerometer[i].standard_normal()
            measured = Measurement(
                wheel_speed=np.array([speed]),
                brake_pressure=np.array([torque / BRAKE_GAIN]),
                speed=0.0,
                acceleration=CAR.accelerometer.reading(float(acceleration[i]) + error),
            )
            commands[i] = controllers[i].command(samples * STEP, measured, demand / BRAKE_GAIN)
        return commands

    for _ in range(_ROLLING):
        sense(0.0, 1.0, np.ones(len(seeds), dtype=bool))
        plant.roll()
    return brake_to_rest(plant, lambda since, running: sense(plant.demand, trouble.gain_at(since), running))
