"""Perturbations: differences between the car that brakes and its nominal parameters."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.sensor_noise import CHAPTER_NOISE, SensorNoise
from vehicle_models.single_corner import CornerParameters
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_LOWEST, _HIGHEST = 1.0, 14.0
"""[Hz] of a wheel load on a rough road."""
_TONES = 27


@dataclass(frozen=True)
class Trouble:
    """A disturbance of the plant; the defaults disturb nothing."""

    name: str = "none"
    noise: float = 1.0
    """Standard deviations of wheel speed and pressure over the chapter's."""
    gain: float = 1.0
    """Brake torque over that of the vehicle file."""
    mass: float = 1.0
    """Mass, and the load with it, over that of the vehicle file."""
    radius: float = 1.0
    """Over that of the vehicle file."""
    delay: float = 0.0
    """More delay of the hydraulics [s]."""
    apply_rate: float = 1.0
    """Rate of rise over that of the parameters."""
    load_variation: float = 0.0
    """Standard deviation of the wheel load over its mean, 1 to 14 Hz."""
    fading: float = 0.0
    """Share of the brake torque that is lost in a second [1/s]."""
    relaxation_length: float = 0.0
    """Of the tyres [m]; 0: that of the vehicle file. The single corner has none."""
    hill: float = 0.0
    """Sine of the slope that comes within 30 m soon after the onset. The single corner has none."""

    def corner(self, told: CornerParameters) -> CornerParameters:
        """Return the corner that brakes, of the one in the vehicle file."""
        return replace(
            told,
            mass=self.mass * told.mass,
            vertical_load=self.mass * told.vertical_load,
            radius=self.radius * told.radius,
        )

    def vehicle(self, told: Vehicle) -> Vehicle:
        """Return the car that brakes, of the one in the vehicle file."""
        wheels = tuple(
            replace(
                wheel,
                radius=self.radius * wheel.radius,
                brake_gain=self.gain * wheel.brake_gain,
                relaxation_length=self.relaxation_length or wheel.relaxation_length,
            )
            for wheel in told.wheels
        )
        return replace(told, mass=self.mass * told.mass, wheels=wheels)

    @property
    def steady(self) -> "Trouble":
        """The same on an even road."""
        return replace(self, load_variation=0.0)

    @property
    def actuator(self) -> ActuatorParameters:
        """Its hydraulics."""
        told = ActuatorParameters()
        return replace(told, delay=told.delay + self.delay, apply_rate=self.apply_rate * told.apply_rate)

    @property
    def sensors(self) -> SensorNoise:
        """Noise of its sensors; that of the speed sensor is not used."""
        return SensorNoise(
            self.noise**2 * CHAPTER_NOISE.wheel_speed_variance,
            CHAPTER_NOISE.speed_variance,
            self.noise**2 * CHAPTER_NOISE.torque_variance,
        )

    def gain_at(self, time: float) -> float:
        """Brake torque over that of the vehicle file, a time after the onset [s]."""
        return self.gain * max(1.0 - self.fading * max(time, 0.0), 0.0)

    def load_at(self, time: float, phases: Array) -> Array:
        """Wheel load over its mean at a time [s], shape (n,); `phases` [rad] has the shape (n, tones)."""
        if self.load_variation == 0.0:
            return np.ones(len(phases))
        frequencies = np.linspace(_LOWEST, _HIGHEST, _TONES)
        tones = np.sin(2.0 * np.pi * frequencies * time + phases).sum(axis=1)
        return np.asarray(1.0 + self.load_variation * np.sqrt(2.0 / _TONES) * tones)

    @staticmethod
    def phases(generator: np.random.Generator) -> Array:
        """Draw the phases of a road [rad], shape (tones,)."""
        return generator.uniform(0.0, 2.0 * np.pi, _TONES)


NONE = Trouble()
_OF_ANY_CAR = (
    Trouble("gain -20 %", gain=0.8),
    Trouble("gain +20 %", gain=1.2),
    Trouble("mass -20 %", mass=0.8),
    Trouble("mass +20 %", mass=1.2),
    Trouble("radius -2 %", radius=0.98),
    Trouble("radius +2 %", radius=1.02),
    Trouble("delay +10 ms", delay=0.01),
    Trouble("delay +20 ms", delay=0.02),
    Trouble("apply rate -30 %", apply_rate=0.7),
)
TROUBLES: tuple[Trouble, ...] = (
    Trouble("noise x2", noise=2.0),
    *_OF_ANY_CAR,
    Trouble("load varies 5 %", load_variation=0.05),
    Trouble("load varies 10 %", load_variation=0.10),
    Trouble("gain fades 10 %/s", fading=0.1),
)
"""Of the single corner."""
CAR_TROUBLES: tuple[Trouble, ...] = (
    *_OF_ANY_CAR,
    Trouble("relaxation 0.2 m", relaxation_length=0.2),
    Trouble("relaxation 0.5 m", relaxation_length=0.5),
    Trouble("hill +6 %", hill=0.06),
    Trouble("hill -6 %", hill=-0.06),
)
"""Of a car with four wheels; only that of `model: car` has the last four."""
