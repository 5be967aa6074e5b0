"""Input and output of the detector at one stamp."""

from enum import Enum
from math import nan

from vehicle_models.reason import Reason


class Method(Enum):
    """Source of the sign; the values are those of the parameter and of friction_msgs/FrictionSlope."""

    SLIP_POSITION = "slip_position"
    SLIP = "slip"
    NO_SLIP = "no_slip"


class SlopeSample:
    """One sample of one wheel."""

    def __init__(
        self,
        stamp: int,
        wheel_speed: float,
        brake_torque: float,
        slip: float = nan,
        slip_rate: float = nan,
        vehicle_speed: float = nan,
        acceleration: float = nan,
    ) -> None:
        """Hold what is known. From the slip on, what is not known is NaN.

        Args:
            stamp: [ns].
            wheel_speed: [rad/s], forward rolling positive.
            brake_torque: [N m], >= 0 but for noise.
            slip: [-], braking positive.
            slip_rate: [1/s].
            vehicle_speed: [m/s].
            acceleration: of the car [m/s^2], forward positive.
        """
        self.stamp = stamp
        self.wheel_speed = wheel_speed
        self.brake_torque = brake_torque
        self.slip = slip
        self.slip_rate = slip_rate
        self.vehicle_speed = vehicle_speed
        self.acceleration = acceleration


class SlopeEstimate:
    """Sign of the slope mu_1 `delay` before the stamp, and the last crossing."""

    def __init__(
        self,
        sign: int,
        h: float,
        indicator: float,
        delay: float,
        crossings: int,
        crossing_sign: int,
        slip_at_crossing: float,
        crossing_stamp: int,
        method: Method,
        load_transfer: bool,
        reason: Reason,
        text: str,
        probability: float = nan,
    ) -> None:
        """Hold what is estimated.

        Args:
            sign: +1 stable side, -1 beyond the peak, 0 not known.
            h: H of (8.3) [rad/s^3]; NaN where unknown.
            indicator: H times the sign of slip rate or eta [rad/s^3]; 0 in the dead zone of that sign, NaN where
                unknown.
            delay: delay of h and indicator behind the stamp [s]; negative where they are predicted, NaN where unknown.
            crossings: sign changes since start or reset.
            crossing_sign: sign after the last crossing; 0 before the first.
            slip_at_crossing: slip at the last crossing [-], compensated for the delay; NaN if unknown.
            crossing_stamp: time of the last crossing [ns], compensated for the delay; 0 before the first.
            method: equation of the indicator.
            load_transfer: whether h is without the part of a changing vertical load.
            reason: why the sign may not be used.
            text: the reason in words, empty where it is OK.
            probability: that the wheel is beyond the peak [-], NaN where unknown and of the equations.
        """
        self.sign = sign
        self.h = h
        self.indicator = indicator
        self.delay = delay
        self.crossings = crossings
        self.crossing_sign = crossing_sign
        self.slip_at_crossing = slip_at_crossing
        self.crossing_stamp = crossing_stamp
        self.method = method
        self.load_transfer = load_transfer
        self.reason = reason
        self.text = text
        self.probability = probability
