"""The car with its brakes and sensors, one sample of the recording at a time."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, floor, pi, sqrt

import numpy as np

from corner_sim.car.car import STEP, Car
from corner_sim.car.car_parameters import CarParameters
from vehicle_models.constants import GRAVITY


class Brake:
    """One brake."""

    def __init__(self, gain: float, fading: float, fading_energy: float, dt: float) -> None:
        """Begin cold. Arguments as in CarParameters; `dt` [s] is the time step."""
        self._gain = gain
        self._fading, self._fading_energy = fading, fading_energy
        self._dt = dt
        self._work = 0.0

    @property
    def gain(self) -> float:
        """Torque over pressure now [N m/Pa]."""
        return self._gain * (1.0 - self._fading * min(self._work / self._fading_energy, 1.0))

    def torque(self, pressure: float, wheel_speed: float) -> float:
        """Torque [N m] over the next step, by pressure [Pa] at the wheel speed [rad/s]."""
        torque = self.gain * pressure
        self._work += torque * wheel_speed * self._dt
        return torque


class LateSignal:
    """Values of every step, given back as they were a while ago; before the first it gives the first."""

    def __init__(self, delay: float, dt: float) -> None:
        """`delay` [s] >= 0 need be no multiple of the step dt [s]."""
        whole = floor(delay / dt + 1e-9)
        self._part = delay / dt - whole
        self._past: deque[float] = deque(maxlen=whole + 2)

    def put(self, value: float) -> None:
        """Take the value of the present step."""
        if not self._past:
            self._past.extend([value] * (self._past.maxlen or 0))
        self._past.append(value)

    def value(self) -> float:
        """Value `delay` before the last step that was put, linear between steps."""
        return self._past[1] + max(self._part, 0.0) * (self._past[0] - self._past[1])


class Encoder:
    """Counts edges over a sample interval and the time between the last edges before its ends.

    A published speed is n 2 pi / teeth / (t_last - t_last_before): the mean speed over the time between two edges,
    which ends up to a tooth before the stamp. Times are of a timer of 1 microsecond. Without a new edge the speed is at
    most a tooth over the time since the last edge, and the last one otherwise. Where the ring lacks teeth no edges
    come, and the unit does not know it.
    """

    TIMER = 1e-6
    """Resolution of the edge times [s]."""

    def __init__(self, teeth: int, speed: float, angle: float, missing: int = 0) -> None:
        """Begin at `speed` [rad/s] and `angle` [rad] of the wheel after its last edge, in [0, 2 pi / teeth).

        The last `missing` of the `teeth` in a revolution are not there.
        """
        self._teeth, self._missing = teeth, missing
        self._seen = 0
        self._pitch = 2.0 * pi / teeth
        self._angle = angle
        self._edge_count = 0
        self._edge_time = -angle / speed
        self._published = (0, self._edge_time, speed)

    def turn(self, time: float, dt: float, begin: float, end: float) -> None:
        """Take the motion from `time` [s] over dt [s], its speed [rad/s] changing linearly."""
        before = self._angle
        self._angle += 0.5 * dt * (begin + end)
        count = floor(self._angle / self._pitch)
        while count > self._edge_count and count % self._teeth >= self._teeth - self._missing:
            count -= 1
        if count > self._edge_count:
            gone = count // self._teeth - self._edge_count // self._teeth
            self._seen += count - self._edge_count - gone * self._missing
            self._edge_count = count
            # angle of the last edge: (begin + growth t / 2) t = rest
            rest, growth = count * self._pitch - before, (end - begin) / dt
            passed = 2.0 * rest / (begin + sqrt(max(begin * begin + 2.0 * growth * rest, 0.0)))
            self._edge_time = round((time + min(passed, dt)) / self.TIMER) * self.TIMER

    def publish(self, time: float) -> float:
        """Wheel speed [rad/s] of the interval that ends at `time` [s]."""
        count, edge_time, speed = self._published
        if self._seen > count:
            speed = (self._seen - count) * self._pitch / (self._edge_time - edge_time)
        elif time > edge_time:
            speed = min(speed, self._pitch / (time - edge_time))
        self._published = (self._seen, self._edge_time, speed)
        return speed


def ideal(speeds: Sequence[float], variance: float, rng: np.random.Generator) -> list[float]:
    """Wheel speeds at their stamp with white noise of `variance` [rad^2/s^2], as in section 8.3.2."""
    noise = rng.normal(0.0, sqrt(variance), len(speeds)).tolist()
    return [speed + error for speed, error in zip(speeds, noise, strict=True)]


@dataclass(frozen=True)
class Measurement:
    """Sensor readings at a sample."""

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

    def __init__(self, parameters: CarParameters, speed: float, seed: int, car: Car | None = None) -> None:
        """Begin rolling freely at `speed` [m/s] > 0; `seed` is that of the noise and of the road.

        `car` is one that is made of the same three; None: one that stays on its path.

        Raises:
            ValueError: the sample rate is no divisor of 1000 Hz.
        """
        p, s = parameters, parameters.sensors
        if round(1.0 / STEP) % s.sample_rate:
            raise ValueError(f"sample_rate = {s.sample_rate} Hz must divide {round(1.0 / STEP)} Hz")
        self.car = Car(p, speed, seed) if car is None else car
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
        force = s.acceleration_scale * self._force.value() + s.acceleration_bias
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
