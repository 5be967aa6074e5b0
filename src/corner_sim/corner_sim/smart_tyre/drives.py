"""Drives of section 8.4 at prescribed speed: the dynamic test of Figure 8.20 and the quasi-static ones of Figure 8.21.

The forces are those of `vehicle_models.wheel_forces`; the road adds a variation of the load between 1 and 12 Hz.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import WheelForces, coasting_acceleration, wheel_forces

Array = NDArray[np.float64]
CAR = load_vehicle("smart_tyre_car")
"""Car of the experiments."""
HARD_BRAKING = 8.0
"""Deceleration of the dynamic drive [m/s^2]."""
HISTORY_RATE = 1000.0
"""Sample rate of a drive [Hz]."""


@dataclass(frozen=True)
class Drive:
    """A straight drive, sampled at HISTORY_RATE; all arrays of shape (n,)."""

    time: Array
    """Time from 0 [s]."""
    speed: Array
    """[m/s]"""
    acceleration: Array
    """[m/s^2]"""
    forces: WheelForces
    """Forces with the load variation of an uneven road."""
    smooth: WheelForces
    """Forces on a perfectly even road, from load transfer alone."""


def dynamic_drive(
    car: Vehicle = CAR, *, road_seed: int, unevenness: float = 0.03, braking: float = HARD_BRAKING
) -> Drive:
    """Return the minute of Figure 8.20: 8 m/s, full acceleration to 22 m/s, cruise, hard braking, 8 m/s again.

    Args:
        car: the car.
        road_seed: seed of the unevenness.
        unevenness: standard deviation of Fz over the static load, 1 to 12 Hz [-].
        braking: deceleration of the braking [m/s^2].
    """
    end = 42.0 + 14.0 / braking
    corners = np.array([0.0, 14.0, 14.4, 19.0, 19.4, 42.0, 42.15, end, end + 0.15, 60.0])
    values = np.array([0.0, 0.0, 2.8, 2.8, 0.0, 0.0, -braking, -braking, 0.0, 0.0])
    time = np.arange(0.0, 60.0, 1.0 / HISTORY_RATE, dtype=np.float64)
    acceleration = np.interp(time, corners, values)
    speed = 8.0 + np.cumsum(acceleration) / HISTORY_RATE
    return _drive(car, time, speed, acceleration, road_seed, unevenness)


def quasi_static_drives(car: Vehicle = CAR, *, road_seed: int, unevenness: float = 0.03) -> tuple[Drive, Drive]:
    """Return very slow acceleration from 10 to 25 m/s, after 8 s at 8 m/s, and coasting down from 25 to 10 m/s."""
    time = np.arange(0.0, 110.0, 1.0 / HISTORY_RATE, dtype=np.float64)
    acceleration = np.interp(time, [0.0, 8.0, 8.2, 9.8, 10.0], [0.0, 0.0, 1.0, 1.0, 0.16])
    up = _drive(car, time, 8.0 + np.cumsum(acceleration) / HISTORY_RATE, acceleration, road_seed, unevenness)
    speeds = [25.0]
    while speeds[-1] > 10.0:
        speeds.append(speeds[-1] + float(coasting_acceleration(car, speeds[-1])) / HISTORY_RATE)
    speed = np.asarray(speeds)
    coasting = coasting_acceleration(car, speed)
    down = _drive(car, np.arange(len(speed)) / HISTORY_RATE, speed, coasting, road_seed + 1, unevenness)
    return up, down


def steady_drive(
    speed: float, duration: float, car: Vehicle = CAR, *, road_seed: int, unevenness: float = 0.0
) -> Drive:
    """Return a drive at constant `speed` [m/s] for `duration` [s]."""
    time = np.arange(0.0, duration, 1.0 / HISTORY_RATE, dtype=np.float64)
    return _drive(car, time, np.full(time.shape, speed), np.zeros(time.shape), road_seed, unevenness)


def _drive(car: Vehicle, time: Array, speed: Array, acceleration: Array, road_seed: int, unevenness: float) -> Drive:
    smooth = wheel_forces(car, speed, acceleration)
    band = signal.butter(4, (1.0, 12.0), "bandpass", fs=HISTORY_RATE, output="sos")
    lead = round(2.0 * HISTORY_RATE)
    white = np.random.default_rng(road_seed).standard_normal((2, lead + len(time)))
    road = signal.sosfilt(band, white)[:, lead:]
    impulse = np.zeros(lead)
    impulse[0] = 1.0
    road *= unevenness * 0.25 * car.mass * GRAVITY / np.sqrt(np.sum(signal.sosfilt(band, impulse) ** 2))
    forces = WheelForces(smooth.fx_front, smooth.fx_rear, smooth.fz_front + road[0], smooth.fz_rear + road[1])
    return Drive(time, speed, acceleration, forces, smooth)
