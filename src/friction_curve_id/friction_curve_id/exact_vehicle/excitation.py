"""Excitation of the latest samples, and braking without drive torque."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_TORQUE_SPAN = 8.0
_BEND = 6.0
"""Thresholds in standard deviations of the measurement: twice what noise alone reaches within some ten samples."""
_NO_TORQUE = 1.5
"""Mean torque of a released brake, in standard deviations of one sample."""
_NO_SLIP = 0.01
_DRIVEN = 4.0
"""Threshold of a driven wheel, in standard deviations of the trend."""


@dataclass(frozen=True)
class WheelTrend:
    """Straight line through wheel speeds over some samples."""

    rate: float
    """[rad/s^2]"""
    stddev: float
    """Standard deviation of the rate [rad/s^2]; inf for fewer than four samples."""
    bend: float
    """Largest distance from the line [rad/s]."""


def wheel_trend(time: Array, wheel_speed: Array, wheel_speed_noise: float) -> WheelTrend:
    """Fit the line over `time` [s] to wheel speeds [rad/s], shapes (n,), of this noise [rad/s]."""
    count = len(time)
    if count < 4:
        return WheelTrend(0.0, float("inf"), 0.0)
    centred = time - time.sum() / count
    spread = float(centred @ centred)
    rate = float(centred @ wheel_speed) / spread
    bend = float(np.abs(wheel_speed - wheel_speed.sum() / count - rate * centred).max())
    return WheelTrend(rate, wheel_speed_noise / spread**0.5, bend)


def is_excited(trend: WheelTrend, torque: Array, wheel_speed_noise: float, torque_noise: float) -> bool:
    """Whether the torque [N m], shape (n,), varies, or the braked wheel does more than decelerate."""
    limit = _TORQUE_SPAN * torque_noise
    if float(torque.max() - torque.min()) > limit:
        return True
    return trend.bend > _BEND * wheel_speed_noise and float(torque.mean()) > limit


def is_released(torque: Array, slip: Array, torque_noise: float) -> bool:
    """Whether brake torque [N m] and slip [-], shapes (n,), have gone."""
    return float(torque.mean()) < _NO_TORQUE * torque_noise and float(np.abs(slip).max()) < _NO_SLIP


def is_driven(trend: WheelTrend, torque: Array, torque_noise: float) -> bool:
    """Whether a wheel without brake torque [N m], shape (n,), changes its speed, by the engine or a slope."""
    return abs(trend.rate) > _DRIVEN * trend.stddev and float(torque.mean()) < _NO_TORQUE * torque_noise
