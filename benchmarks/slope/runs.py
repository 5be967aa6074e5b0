"""Braking manoeuvres of one corner for the slope sign: the truth once, its sensors with the noise of every seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.manoeuvres import hold_torque
from benchmarks.protocol import BRAKE_GAIN, CAR, CORNER, DT, SPEED, STEP
from corner_sim import messages
from corner_sim.sensors import Measurement
from vehicle_models import burckhardt
from vehicle_models.sensor_noise import SensorNoise
from vehicle_models.single_corner import SingleCorner
from vehicle_models.surfaces import surface

Array = NDArray[np.float64]

_ROLLING = 0.4
"""Free rolling before the brake [s]."""
_RAMP = 0.25
"""[s]"""
_RELEASE_RATE = 5000.0
"""Fastest fall of torque [N m/s], that of the brake actuator."""
_AFTER = 0.15
"""Time after the slip has come back through the peak [s]."""


@dataclass(frozen=True)
class Run:
    """True history of a manoeuvre, arrays of shape (samples,)."""

    theta: Array
    time: Array
    """[s], first sample at one sample time."""
    wheel_speed: Array
    speed: Array
    torque: Array
    slip: Array

    @property
    def lambda_max(self) -> float:
        """Slip at the peak [-]."""
        return float(burckhardt.peak(self.theta)[0])

    @property
    def acceleration(self) -> Array:
        """v_dot [m/s^2]."""
        return np.asarray(-CORNER.gravity * burckhardt.friction(self.theta, self.slip))

    @property
    def wheel_acceleration(self) -> Array:
        """omega_dot [rad/s^2]."""
        moment = CORNER.radius * CORNER.vertical_load * burckhardt.friction(self.theta, self.slip)
        return np.asarray((moment - self.torque) / CORNER.inertia)

    @property
    def eta(self) -> Array:
        """Normalised wheel deceleration [-]."""
        return -self.wheel_acceleration * CORNER.radius / CORNER.gravity

    @property
    def slip_rate(self) -> Array:
        """[1/s]"""
        return ((1.0 - self.slip) * self.acceleration - CORNER.radius * self.wheel_acceleration) / self.speed

    def crossings(self) -> tuple[float, float]:
        """Times [s] at which the slip passes the peak upwards and downwards, interpolated; NaN where it does not."""
        beyond = self.slip > self.lambda_max
        times = [np.nan, np.nan]
        for which, change in enumerate((1, -1)):
            found = np.flatnonzero(np.diff(beyond.astype(int)) == change)
            if found.size:
                k = found[0]
                share = (self.lambda_max - self.slip[k]) / (self.slip[k + 1] - self.slip[k])
                times[which] = float(self.time[k] + share * DT)
        return times[0], times[1]


@cache
def through_the_peak(name: str) -> Run:
    """Ramp and hold of manoeuvre B until twice lambda_max, then release until shortly after the slip is back."""
    theta = surface(name)
    twice = 2.0 * float(burckhardt.peak(theta)[0])
    hold = float(hold_torque("B", theta, CORNER)[0])
    released = False
    back = 0

    def torque(time: float, last: float, slip: float) -> float | None:
        nonlocal released, back
        released = released or slip > twice
        back += released and slip < 0.5 * twice
        if back * DT > _AFTER:
            return None
        if released:
            return max(last - _RELEASE_RATE * DT, 0.0)
        return hold * min(max(time - _ROLLING, 0.0) / _RAMP, 1.0)

    return _simulate(theta, torque)


@cache
def below_the_peak(name: str, ratio: float, duration: float) -> Run:
    """Ramp over 0.25 s and hold at `ratio` of the peak torque for `duration` [s]: there is nothing to detect."""
    theta = surface(name)
    hold = ratio * float(CORNER.peak_torque(theta))

    def torque(time: float, _last: float, _slip: float) -> float | None:
        if time > _ROLLING + _RAMP + duration:
            return None
        return hold * min(max(time - _ROLLING, 0.0) / _RAMP, 1.0)

    return _simulate(theta, torque)


def _simulate(theta: Array, torque: Any) -> Run:
    corner = SingleCorner(CORNER, [SPEED])
    rows = [(DT, SPEED / CORNER.radius, SPEED, 0.0, 0.0)]
    while True:
        time, _, _, last, slip = rows[-1]
        end = torque(time + DT, last, slip)
        if end is None:
            return Run(theta, *np.array(rows).T)
        corner.step(last, end, theta, DT)
        rows.append((time + DT, float(corner.wheel_speed[0]), float(corner.speed[0]), end, float(corner.slip[0])))


def sensor_messages(run: Run, noise: SensorNoise, acceleration_stddev: float, seed: int) -> Iterator[list[Any]]:
    """The messages of every sample of a run: speed sensor, accelerometer, pressure, wheel speed; (topic, message)."""
    noises = np.random.default_rng(seed).standard_normal((4, run.time.size))
    wheel_speed = run.wheel_speed + np.sqrt(noise.wheel_speed_variance) * noises[0]
    torque = run.torque + np.sqrt(noise.torque_variance) * noises[1]
    speed = run.speed + np.sqrt(noise.speed_variance) * noises[2]
    acceleration = run.acceleration + acceleration_stddev * noises[3]
    for k in range(run.time.size):
        measured = Measurement(
            wheel_speed=wheel_speed[k : k + 1],
            brake_pressure=torque[k : k + 1] / BRAKE_GAIN,
            speed=float(speed[k]),
            acceleration=float(acceleration[k]),
        )
        yield messages.sensors((k + 1) * STEP, CAR, measured, noise, acceleration_stddev**2)
