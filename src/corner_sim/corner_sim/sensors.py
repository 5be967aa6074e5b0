"""Sensors of the plant: the true values plus seeded white noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corner_sim.plant import PlantSample
from vehicle_models.sensor_noise import SensorNoise

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measurement:
    """What the sensors say of one sample."""

    wheel_speed: Array
    """[rad/s], shape (n,)."""
    brake_pressure: Array
    """[Pa], shape (n,)."""
    speed: float
    """Vehicle speed [m/s]."""
    acceleration: float
    """Longitudinal acceleration [m/s^2], forward positive."""


class Sensors:
    """Sensors of n wheels; each kind draws from its own stream, so that one does not shift the others."""

    def __init__(
        self, noise: SensorNoise, acceleration_variance: float, acceleration_offset: float, brake_gain: Array, seed: int
    ) -> None:
        """Seed the sensors.

        Args:
            noise: variances of wheel speed, vehicle speed and torque (section 8.3.2).
            acceleration_variance: of the accelerometer [m^2/s^4], >= 0.
            acceleration_offset: constant error of the accelerometer [m/s^2].
            brake_gain: k of T_b = k p (1.1) [N m/Pa], shape (n,).
            seed: same seed, same noise.
        """
        self._noise = noise
        self._acceleration_stddev = float(np.sqrt(acceleration_variance))
        self._acceleration_offset = acceleration_offset
        self._brake_gain = brake_gain
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
            brake_pressure=(sample.brake_torque + torque_error) / self._brake_gain,
            speed=sample.speed + float(np.sqrt(noise.speed_variance) * self._speed.standard_normal()),
            acceleration=sample.acceleration
            + self._acceleration_offset
            + self._acceleration_stddev * float(self._acceleration.standard_normal()),
        )
