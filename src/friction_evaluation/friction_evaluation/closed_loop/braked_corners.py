"""Corners side by side on one road, each with a brake actuator, noisy sensors and a controller of its own."""

import numpy as np
from numpy.typing import NDArray

from corner_sim.sensors import Measurement
from friction_evaluation.closed_loop.controller import Controller, Parameters
from friction_evaluation.protocol import CAR, DT, SPEED, STEP
from vehicle_models.brake_actuator import BrakeActuator
from vehicle_models.sensor_noise import SensorNoise
from vehicle_models.single_corner import SingleCorner
from vehicle_models.surfaces import surface
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

DEMAND_RATIO = 1.5
"""Demand in units of the peak torque."""


class BrakedCorners:
    """The first wheel of a car, once for each seed of the sensor noise; at the start they roll freely."""

    def __init__(
        self, name: str, seeds: range, noise: SensorNoise, parameters: Parameters, vehicle: Vehicle = CAR
    ) -> None:
        """Start at SPEED on the surface `name`.

        Args:
            name: of the surface.
            seeds: of the sensor noise.
            noise: its variances.
            parameters: those of friction_slope and abs_supervisor.
            vehicle: its first wheel brakes.
        """
        count = len(seeds)
        wheel = vehicle.wheels[0]
        braked = vehicle.corner(wheel.name)
        self.theta = surface(name)
        self.corner = SingleCorner(braked, np.full(count, SPEED))
        self.controllers = [Controller(vehicle, noise, *parameters) for _ in seeds]
        self.torque: Array = np.zeros(count)
        """Brake torque [N m], shape (n,)."""
        self._gain = wheel.brake_gain
        self._demand = DEMAND_RATIO * float(braked.peak_torque(self.theta))
        self._actuator = BrakeActuator(count, DT)
        self._noise = noise
        self._accelerometer = vehicle.accelerometer
        self._generators = [np.random.default_rng(seed) for seed in seeds]
        # A stream of its own: the wheel's noise does not depend on whether the car's speed is measured.
        self._speed_generators = [np.random.default_rng((seed, 1)) for seed in seeds]
        self._samples = 0

    def step(self, braking: bool, running: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Advance by a sample time, braked with DEMAND_RATIO or not at all; return the commands, shape (n,).

        Where `running` is false, shape (n,), no sensor is read and the command is 0.
        """
        self._samples += 1
        demand = self._demand if braking else 0.0
        commands = np.zeros(len(self.controllers), dtype=np.int64)
        acceleration = self.corner.acceleration(self.theta)
        for i in np.flatnonzero(running).tolist():
            draw = self._generators[i].standard_normal(2)
            of_car = self._speed_generators[i].standard_normal()
            speed = self.corner.wheel_speed[i] + np.sqrt(self._noise.wheel_speed_variance) * draw[0]
            pressure = (self.torque[i] + np.sqrt(self._noise.torque_variance) * draw[1]) / self._gain
            measured = Measurement(
                wheel_speed=np.array([speed]),
                brake_pressure=np.array([pressure]),
                speed=float(self.corner.speed[i] + np.sqrt(self._noise.speed_variance) * of_car),
                acceleration=self._accelerometer.reading(float(acceleration[i])),
            )
            commands[i] = self.controllers[i].command(self._samples * STEP, measured, demand / self._gain)
        after = self._actuator.step(demand, commands)
        self.corner.step(self.torque, after, self.theta, DT)
        self.torque = after
        return commands
