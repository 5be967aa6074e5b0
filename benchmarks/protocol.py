"""Protocol of section 8.3.2: corner, initial speed, sample time, manoeuvres A to C and their noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corner_sim.corner import SingleCorner
from corner_sim.sensors import CHAPTER_NOISE
from vehicle_models import burckhardt
from vehicle_models.vehicle import CornerParameters
from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "chapter_corner"
CAR = load_vehicle(VEHICLE)
"""A car of one wheel."""
WHEEL = CAR.wheel_names[0]
CORNER = CAR.corner(WHEEL)
BRAKE_GAIN = CAR.wheel(WHEEL).brake_gain
"""k in T_b = k p [N m/Pa]."""
SPEED = 30.0
"""At the start, rolling freely [m/s]."""
DT = 0.005
"""Sample time [s]."""
STEP = 5_000_000
"""Sample time [ns]."""
ACCELERATION_STDDEV = 0.1
"""Noise of the accelerometer [m/s^2]: the chapter gives none, and wheel_slip is tuned for this."""
ACCELERATION_OFFSET = 0.15
"""Of the accelerometer in stops without a speed sensor [m/s^2]."""


Array = NDArray[np.float64]

SAMPLES = 100
RAMP_TIMES = {"A": 0.5, "B": 0.25, "C": 0.1}
"""Duration of the torque ramp [s]."""
_FINAL_SLIP = 1.5
"""Last slip, in units of lambda_max."""
_LEVELS = (0.5, 4.0)
"""Search interval of the level, in units of the torque that holds the peak."""
_BISECTIONS = 30


@dataclass(frozen=True)
class Truth:
    """Noise-free history of n manoeuvres, arrays of shape (n, samples)."""

    theta: Array
    """Shape (n, 3)."""
    time: Array
    """[s], shape (samples,)."""
    wheel_speed: Array
    """[rad/s]"""
    speed: Array
    """[m/s]"""
    torque: Array
    """[N m]"""
    slip: Array
    """[-]"""

    def noisy(self, run: int, generator: np.random.Generator) -> tuple[Array, Array, Array]:
        """Measured (wheel speed, speed, torque) of manoeuvre number `run` with white noise, shapes (samples,)."""
        return noisy((self.wheel_speed[run], self.speed[run], self.torque[run]), generator)


def noisy(signals: tuple[Array, Array, Array], generator: np.random.Generator) -> tuple[Array, Array, Array]:
    """Measured (wheel speed, speed, torque) with white noise, from the true ones, shapes (samples,)."""
    wheel_speed, speed, torque = signals
    noise = CHAPTER_NOISE
    return (
        wheel_speed + generator.normal(0.0, noise.wheel_speed_variance**0.5, wheel_speed.size),
        speed + generator.normal(0.0, noise.speed_variance**0.5, speed.size),
        torque + generator.normal(0.0, noise.torque_variance**0.5, torque.size),
    )


def brake_torque(manoeuvre: str, level: ArrayLike, time: ArrayLike) -> Array:
    """Brake torque [N m] at `time` [s], shape (..., samples), for levels [N m] of shape (...)."""
    return np.asarray(level)[..., np.newaxis] * np.minimum(np.asarray(time) / RAMP_TIMES[manoeuvre], 1.0)


def hold_torque(manoeuvre: str, theta: ArrayLike, corner: CornerParameters = CORNER) -> Array:
    """The level [N m] for each road theta, shape (n, 3): the torque at the end of the ramp, shape (n,)."""
    roads = np.atleast_2d(np.asarray(theta, dtype=np.float64))
    target = _FINAL_SLIP * burckhardt.peak(roads)[0]
    peak_torque = corner.peak_torque(roads)
    low, high = _LEVELS[0] * peak_torque, _LEVELS[1] * peak_torque
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        too_low = _drive(manoeuvre, middle, roads, corner).slip[:, -1] < target
        low, high = np.where(too_low, middle, low), np.where(too_low, high, middle)
    return np.asarray(0.5 * (low + high))


def braking(manoeuvre: str, theta: ArrayLike, corner: CornerParameters = CORNER) -> Truth:
    """Drive manoeuvre A, B or C on each road theta, shape (n, 3) or (3,).

    Raises:
        KeyError: the manoeuvre is none of A, B and C.
    """
    roads = np.atleast_2d(np.asarray(theta, dtype=np.float64))
    return _drive(manoeuvre, hold_torque(manoeuvre, roads, corner), roads, corner)


def _drive(manoeuvre: str, level: Array, theta: Array, corner: CornerParameters) -> Truth:
    time: Array = np.arange(SAMPLES, dtype=np.float64) * DT
    torque = brake_torque(manoeuvre, level, time)
    plant = SingleCorner(corner, np.full(len(theta), SPEED))
    states = []
    for k in range(SAMPLES):
        states.append((plant.wheel_speed, plant.speed, plant.slip))
        if k < SAMPLES - 1:
            plant.step(torque[:, k], torque[:, k + 1], theta, DT)
    history: Array = np.moveaxis(np.array(states, dtype=np.float64), 0, -1)
    return Truth(theta, time, history[0], history[1], torque, history[2])
