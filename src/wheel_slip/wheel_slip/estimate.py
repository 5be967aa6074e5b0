"""Output of the slip estimator: one estimate per wheel and sample, with the reason where there is none."""

from dataclasses import dataclass
from enum import IntEnum
from math import nan


class SpeedSource(IntEnum):
    """Where the vehicle speed comes from; the values are those of friction_msgs/WheelSlip."""

    NONE = 0
    SENSOR = 1
    WHEELS = 2
    INTEGRATED = 3


class Reason(IntEnum):
    """Why a slip is not valid; the values are those of friction_msgs/WheelSlip."""

    OK = 0
    NOT_READY = 1
    LOW_SPEED = 2
    NO_SPEED = 3
    BAD_INPUT = 4
    GAP = 5
    UNCERTAIN = 6


@dataclass
class WheelEstimate:
    """Slip of one wheel at one sample. Unknown values are NaN; slip and slip_rate are NaN unless reason is OK."""

    slip: float = nan
    """[-] braking positive"""
    slip_rate: float = nan
    """[1/s]"""
    vehicle_speed: float = nan
    """[m/s]"""
    wheel_speed: float = nan
    """[rad/s], filtered"""
    slip_variance: float = nan
    """[-]"""
    slip_rate_variance: float = nan
    """[1/s^2]"""
    vehicle_speed_variance: float = nan
    """[m^2/s^2]"""
    source: SpeedSource = SpeedSource.NONE
    reason: Reason = Reason.OK
    text: str = ""
    """The reason in words, empty where it is OK."""
