"""Sensors of the plant: the true values plus seeded white noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corner_sim.plant import PlantSample
from vehicle_models.vehicle import Vehicle


@dataclass(frozen=True)
class SensorNoise:
    """Variances of the additive white noise of the sensors."""

    wheel_speed_variance: float = 0.005
    """[rad^2/s^2]"""
    speed_variance: float = 0.25
    """[m^2/s^2]"""
    torque_variance: float = 10.0
    """[N^2 m^2]"""


CHAPTER_NOISE = SensorNoise()
NO_NOISE = SensorNoise(0.0, 0.0, 0.0)


Array = NDArray[np.float64]

TYRE_SAMPLE_RATE = 1.0e4
"""Sample rate of the smart tyres [Hz]."""


@dataclass(frozen=True)
class Measurement:
    """Sensor readings at one sample."""

    wheel_speed: Array
    """[rad/s], shape (n,)."""
    brake_pressure: Array
    """[Pa], shape (n,)."""
    speed: float
    """Vehicle speed [m/s]."""
    acceleration: float
    """Reading of the accelerometer's axis along the car [m/s^2]."""


class Sensors:
    """Sensors of n wheels; each kind draws noise from its own stream, so that one does not shift the others."""

    def __init__(
        self, noise: SensorNoise, acceleration_variance: float, acceleration_bias: float, vehicle: Vehicle, seed: int
    ) -> None:
        """Seed the sensors.

        Args:
            noise: variances of wheel speed, vehicle speed and torque (section 8.3.2).
            acceleration_variance: noise of the accelerometer [m^2/s^4], >= 0.
            acceleration_bias: constant error of the accelerometer on top of that in the vehicle file [m/s^2].
            vehicle: its brakes and the mounting of its accelerometer; wheels in the order of the samples.
            seed: same seed, same noise.
        """
        self._noise = noise
        self._acceleration_stddev = float(np.sqrt(acceleration_variance))
        self._acceleration_bias = acceleration_bias
        self._accelerometer = vehicle.accelerometer
        self._brake_gain = np.array([wheel.brake_gain for wheel in vehicle.wheels])
        streams = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(4))
        self._wheel_speed, self._torque, self._speed, self._acceleration = streams

    def measure(self, sample: PlantSample) -> Measurement:
        """Measure the sample; every call draws new noise."""
        noise = self._noise
        count = sample.wheel_speed.size
        torque_error = np.sqrt(noise.torque_variance) * self._torque.standard_normal(count)
        return Measurement(
            wheel_speed=sample.wheel_speed
            + np.sqrt(noise.wheel_speed_variance) * self._wheel_speed.standard_normal(count),
            brake_pressure=(sample.pressure_torque + torque_error) / self._brake_gain,
            speed=sample.speed + float(np.sqrt(noise.speed_variance) * self._speed.standard_normal()),
            acceleration=self._accelerometer.reading(sample.acceleration)
            + self._acceleration_bias
            + self._acceleration_stddev * float(self._acceleration.standard_normal()),
        )
