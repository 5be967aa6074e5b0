"""The car with its brakes and sensors, one sample of the recording at a time."""

from dataclasses import dataclass
from math import exp, pi

import numpy as np

from corner_sim.car.brake import Brake
from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.encoder import Encoder, ideal
from corner_sim.car.late_signal import LateSignal
from vehicle_models.constants import GRAVITY


@dataclass(frozen=True)
class Measurement:
    """What the sensors say at a sample."""

    time: float
    """[s]"""
    wheel_speed: list[float]
    """[rad/s], shape (4,)"""
    brake_pressure: list[float]
    """[Pa], shape (4,)"""
    acceleration: float
    """Specific force along the car [m/s^2], forward positive."""


class MeasuredCar:
    """Car, brakes and sensors."""

    def __init__(self, parameters: CarParameters, speed: float, seed: int) -> None:
        """Begin rolling freely at `speed` [m/s] > 0; `seed` is that of the noise and of the road.

        Raises:
            ValueError: the sample rate is no divisor of 1000 Hz.
        """
        p, s = parameters, parameters.sensors
        if round(1.0 / STEP) % s.sample_rate:
            raise ValueError(f"sample_rate = {s.sample_rate} Hz must divide {round(1.0 / STEP)} Hz")
        self.car = Car(p, speed, seed)
        self.steps_per_sample = round(1.0 / STEP) // s.sample_rate
        self._p, self._s = p, s
        self._rng = np.random.default_rng([seed, 0])
        self._steps = 0
        self._brakes = [Brake(gain, p.fading, p.fading_energy, STEP) for gain in p.brake_gain]
        self._pressures = [LateSignal(s.pressure_delay, STEP) for _ in range(4)]
        self._follow = 1.0 - exp(-STEP / s.pressure_lag) if s.pressure_lag > 0.0 else 1.0
        self._sensed_pressure = [0.0] * 4
        self._speeds = [LateSignal(s.wheel_delay, STEP) for _ in range(4)]
        self._force = LateSignal(s.acceleration_delay, STEP)
        first = self._rng.uniform(0.0, 1.0, 4).tolist()
        self._encoders = [
            Encoder(s.encoder_teeth, omega, angle * 2.0 * pi / s.encoder_teeth, s.missing_teeth)
            for omega, angle in zip(self.car.wheel_speed, first, strict=True)
            if s.encoder_teeth
        ]
        self._last_speed = list(self.car.wheel_speed)
        self._sense([0.0] * 4, p.slope)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps * STEP

    @property
    def brake_gain(self) -> list[float]:
        """Torque over pressure of each brake now [N m/Pa]."""
        return [brake.gain for brake in self._brakes]

    def step(
        self, pressure: list[float], engine_torque: float = 0.0, slope: float = 0.0, curvature: float = 0.0
    ) -> None:
        """Advance by STEP at pressures [Pa] of the lines, shape (4,); the others as in Car.step."""
        car = self.car
        torque = [
            brake.torque(each, omega)
            for brake, each, omega in zip(self._brakes, pressure, car.wheel_speed, strict=True)
        ]
        car.step(torque, engine_torque, slope, curvature)
        self._steps += 1
        self._sense(pressure, slope + self._p.slope)

    def measure(self) -> Measurement:
        """Read the sensors; once per sample, as encoders count from reading to reading."""
        s, rng = self._s, self._rng
        if self._encoders:
            wheel_speed = [encoder.publish(self.time) for encoder in self._encoders]
        else:
            wheel_speed = ideal([late.value() for late in self._speeds], s.wheel_speed_variance, rng)
        noise = rng.normal(0.0, s.pressure_stddev, 4).tolist()
        pressure = [each + error for each, error in zip(self._sensed_pressure, noise, strict=True)]
        force = s.acceleration_scale * self._force.value() + s.acceleration_offset
        return Measurement(self.time, wheel_speed, pressure, force + float(rng.normal(0.0, s.acceleration_stddev)))

    def _sense(self, pressure: list[float], slope: float) -> None:
        car = self.car
        for i in range(4):
            self._pressures[i].put(pressure[i])
            self._sensed_pressure[i] += self._follow * (self._pressures[i].value() - self._sensed_pressure[i])
            self._speeds[i].put(car.wheel_speed[i])
            if self._encoders:
                speed = self._speeds[i].value()
                # the first call is the state at the start: no time has passed
                self._encoders[i].turn(self.time - STEP, STEP if self._steps else 0.0, self._last_speed[i], speed)
                self._last_speed[i] = speed
        # gravity along the axis of a body whose nose is down by pitch_gain times the deceleration, on this road
        self._force.put(car.acceleration + GRAVITY * (slope + self._p.pitch_gain * car.pitch.angle))
