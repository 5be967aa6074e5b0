"""Input and output of the detector at one stamp."""

from dataclasses import dataclass
from enum import IntEnum
from math import nan


class Method(IntEnum):
    """Where the sign of the slip rate comes from; the values are those of friction_msgs/FrictionSlope."""

    SLIP = 1
    NO_SLIP = 2


METHODS = {"slip": Method.SLIP, "no_slip": Method.NO_SLIP}
"""Methods by their names in the parameter `method`."""


class Reason(IntEnum):
    """Why the sign may not be used; the values are those of friction_msgs/FrictionSlope."""

    OK = 0
    NOT_READY = 1
    LOW_SPEED = 2
    NO_SLIP = 3
    NO_TORQUE = 4
    BAD_INPUT = 5
    GAP = 6
    NOT_BRAKING = 7
    NO_EXCITATION = 8


@dataclass
class SlopeSample:
    """One sample of one wheel. From the slip on, what is not known is NaN."""

    stamp: int
    """[ns]"""
    wheel_speed: float
    """[rad/s], forward rolling positive"""
    brake_torque: float
    """[N m], >= 0 but for noise"""
    slip: float = nan
    """[-], braking positive"""
    slip_rate: float = nan
    """[1/s]"""
    vehicle_speed: float = nan
    """[m/s]"""
    acceleration: float = nan
    """Acceleration of the car [m/s^2], forward positive"""


@dataclass
class SlopeEstimate:
    """Sign of the slope mu_1 `delay` before the stamp, and the last crossing."""

    sign: int = 0
    """+1 stable side, -1 beyond the peak, 0 not known."""
    h: float = nan
    """H of (8.3) [rad/s^3]; NaN where unknown."""
    indicator: float = nan
    """H times the sign of slip rate or eta [rad/s^3]; 0 in the dead zone of that sign, NaN where unknown."""
    delay: float = nan
    """Delay of h and indicator behind the stamp [s]; negative where they are predicted."""
    crossings: int = 0
    """Sign changes since start or reset."""
    crossing_sign: int = 0
    """Sign after the last crossing; 0 before the first."""
    slip_at_crossing: float = nan
    """Slip at the last crossing [-], compensated for the delay; NaN if unknown."""
    crossing_stamp: int = 0
    """Time of the last crossing [ns], compensated for the delay; 0 before the first."""
    method: Method = Method.SLIP
    """Equation of the indicator."""
    load_transfer: bool = False
    """Whether h is without the part of a changing vertical load."""
    reason: Reason = Reason.OK
    text: str = ""
    """The reason in words, empty where it is OK."""
