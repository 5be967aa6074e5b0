"""Corners side by side on one road, each with a brake actuator, noisy sensors and a controller of its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.closed_loop.controller import Controller
from benchmarks.closed_loop.panic_plant import Commands, Flags, PanicPlant
from benchmarks.closed_loop.trouble import NONE, Trouble
from benchmarks.protocol import CAR, STEP
from corner_sim.sensors import Measurement
from friction_runtime.processor import Processor
from vehicle_models.vehicle import Vehicle


@dataclass(frozen=True)
class InertialSensing:
    """What the graph is told of the motion of the car; the defaults are the chapter's."""

    speed_sensor: bool = True
    offset: float = 0.0
    """Of the accelerometer [m/s^2], on top of that of the vehicle file."""
    stddev: float = 0.0
    """Of its noise [m/s^2]."""


class BrakedCorners:
    """The first wheel of a car, once for each seed of the sensor noise; at the start they roll freely."""

    def __init__(
        self,
        surface: str,
        seeds: range,
        make: Callable[[Vehicle], Sequence[Processor]],
        sensing: InertialSensing = InertialSensing(),
        trouble: Trouble = NONE,
        vehicle: Vehicle = CAR,
    ) -> None:
        """Start at SPEED.

        Args:
            surface: its name.
            seeds: of the sensor noise and of the road's unevenness.
            make: makes the processors of a car of one wheel, which command its brake.
            sensing: what the graph is told of the motion of the car.
            trouble: what the graph is not told of.
            vehicle: its first wheel brakes.
        """
        wheel = vehicle.wheels[0]
        phases = np.array([Trouble.phases(np.random.default_rng((seed, 3))) for seed in seeds])
        self.plant = PanicPlant(surface, trouble, phases, vehicle.corner(wheel.name))
        noise = trouble.sensors
        self.controllers = [Controller(vehicle, noise, make, speed_sensor=sensing.speed_sensor) for _ in seeds]
        self._noise, self._sensing = noise, sensing
        self._gain, self._accelerometer = wheel.brake_gain, vehicle.accelerometer
        # Streams of their own: the wheel's noise does not depend on how the car's motion is measured.
        self._generators = [np.random.default_rng(seed) for seed in seeds]
        self._of_speed = [np.random.default_rng((seed, 1)) for seed in seeds]
        self._of_accelerometer = [np.random.default_rng((seed, 2)) for seed in seeds]
        self._samples = 0

    def commands(self, demand: float, running: Flags) -> Commands:
        """Read the sensors and return the commands, shape (n,), under a demand [N m by the vehicle file].

        Where `running` is false, shape (n,), no sensor is read and the command is 0.
        """
        self._samples += 1
        plant, noise, sensing = self.plant, self._noise, self._sensing
        commands = np.zeros(len(self.controllers), dtype=np.int64)
        acceleration = plant.acceleration
        for i in np.flatnonzero(running).tolist():
            draw = self._generators[i].standard_normal(2)
            torque = plant.torque[i] / plant.gain + np.sqrt(noise.torque_variance) * draw[1]
            speed_error = np.sqrt(noise.speed_variance) * self._of_speed[i].standard_normal()
            error = sensing.offset + sensing.stddev * self._of_accelerometer[i].standard_normal()
            measured = Measurement(
                wheel_speed=np.array([plant.corner.wheel_speed[i] + np.sqrt(noise.wheel_speed_variance) * draw[0]]),
                brake_pressure=np.array([torque / self._gain]),
                speed=float(plant.corner.speed[i] + speed_error),
                acceleration=self._accelerometer.reading(float(acceleration[i]) + error),
            )
            commands[i] = self.controllers[i].command(self._samples * STEP, measured, demand / self._gain)
        return commands

    def roll(self, samples: int) -> None:
        """Advance without brake."""
        running = np.ones(len(self.controllers), dtype=bool)
        for _ in range(samples):
            self.plant.advance(0.0, self.commands(0.0, running))

    def brake(self, running: Flags) -> Commands:
        """Advance by a sample under the full demand; return the commands, as above."""
        given = self.commands(self.plant.demand, running)
        self.plant.advance(self.plant.demand, given)
        return given
