"""Measurements of one wheel and its car at one stamp, as the supervisor uses them."""

from collections.abc import Sequence
from math import nan
from typing import Final, NamedTuple

GAP: Final = 0.05
"""[s] after a longer gap between samples what is followed begins anew."""


class Measurements(NamedTuple):
    """Values at one stamp; NaN where one is not known."""

    wheel_speed: float
    """[rad/s]"""
    torque: float
    """Of the brake, measured [N m]."""
    demand: float
    """Of the driver [N m]."""
    others: Sequence[float] = ()
    """Circumferential speeds of the other wheels, those that are known [m/s]."""
    slip: float = nan
    slip_stddev: float = nan
    car_speed: float = nan
    """[m/s]"""
    car_speed_stddev: float = nan
    """[m/s]"""
    car_speed_measured: bool = False
    """Whether a speed sensor is in that speed."""
    inertial: bool = True
    """Whether an accelerometer or a speed sensor is in it; else it comes from the wheels alone."""
    in_curve: bool = False
    """Whether the car is in a curve."""
    slip_text: str = "slip is not known"
    """Why the slip is not known."""
