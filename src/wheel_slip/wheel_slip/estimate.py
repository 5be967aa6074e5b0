"""Slip of a wheel and its rate, with their first-order variances, and what is published of them. Braking is positive.

slip = (v - omega r) / v,    slip_rate = (r / v) (omega v_dot / v - omega_dot)

The variances take speed, wheel speed and their rates as independent, which they are while the speed does not come from
the wheel itself, and which is on the safe side while it does. Only the error of its radius is known to be in both.
"""

from typing import NamedTuple

from vehicle_models.reason import Reason


class SpeedSample(NamedTuple):
    """A measured vehicle speed."""

    stamp: int
    """When it was measured [ns]."""
    speed: float
    """[m/s], forward positive"""
    variance: float
    """[m^2/s^2], > 0"""


class Hypotheses(NamedTuple):
    """Probabilities of what may be the matter with road and sensors [-]; NaN where a sensor is not there."""

    slope_changed: float
    """The road has changed its slope since it was last known."""
    accelerometer_wrong: float
    """The accelerometer is late, turned or stuck."""
    pressures_wrong: float
    """The brake pressures are not those that brake the car."""
    speed_sensor_wrong: float
    """The speed sensor is late, stuck or off."""


class WheelEstimate(NamedTuple):
    """Slip of one wheel at one sample. Unknown values are NaN; slip and slip_rate are NaN unless reason is OK."""

    slip: float
    """[-], braking positive"""
    slip_rate: float
    """[1/s]"""
    vehicle_speed: float
    """Speed of the ground at the wheel [m/s]."""
    wheel_speed: float
    """[rad/s], filtered"""
    slip_variance: float
    """[-]"""
    slip_rate_variance: float
    """[1/s^2]"""
    vehicle_speed_variance: float
    """[m^2/s^2]"""
    reason: Reason
    """Why the slip is not valid."""
    text: str
    """The reason in words, empty where it is OK."""


def slip(speed: float, wheel_speed: float, radius: float) -> float:
    """Slip [-] at vehicle speed [m/s] (not 0), wheel speed [rad/s] and radius [m]."""
    return (speed - wheel_speed * radius) / speed


def slip_variance(
    speed: tuple[float, float], wheel_speed: tuple[float, float], radius: tuple[float, float], covariance: float
) -> float:
    """Variance [-] of slip.

    Args:
        speed: of the ground at the wheel [m/s], and its variance [m^2/s^2].
        wheel_speed: [rad/s], and its variance [rad^2/s^2].
        radius: [m], and the variance of its error as a share.
        covariance: of speed and radius error [m/s]: that of a speed which wheels gave is in the slip of none of them.
    """
    turned = wheel_speed[0] * radius[0] / speed[0]
    of_share = speed[1] / speed[0] ** 2 + radius[1] - 2.0 * covariance / speed[0]
    return turned**2 * max(of_share, 0.0) + (radius[0] / speed[0]) ** 2 * wheel_speed[1]


def slip_rate(speed: float, acceleration: float, wheel_speed: float, wheel_acceleration: float, radius: float) -> float:
    """Slip rate [1/s] from speeds and their rates [m/s, m/s^2, rad/s, rad/s^2]."""
    return radius / speed * (wheel_speed * acceleration / speed - wheel_acceleration)


def slip_rate_variance(
    speed: tuple[float, float],
    acceleration: tuple[float, float],
    wheel_speed: tuple[float, float],
    wheel_acceleration: tuple[float, float],
    radius: float,
) -> float:
    """Variance [1/s^2] of slip_rate; each argument is (value, variance), in the units of slip_rate."""
    v, a, omega = speed[0], acceleration[0], wheel_speed[0]
    by_speed = radius / v**2 * (wheel_acceleration[0] - 2.0 * omega * a / v)
    by_acceleration = radius * omega / v**2
    by_wheel = radius * a / v**2
    by_wheel_acceleration = radius / v
    return (
        by_speed**2 * speed[1]
        + by_acceleration**2 * acceleration[1]
        + by_wheel**2 * wheel_speed[1]
        + by_wheel_acceleration**2 * wheel_acceleration[1]
    )
