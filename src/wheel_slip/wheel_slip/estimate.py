"""Output of the slip estimator: one estimate per wheel and sample, with the reason where there is none."""

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
