"""Measurements of one wheel and its car at one stamp, as the supervisor uses them."""

from collections.abc import Sequence
from math import nan


class Measurements:
    """Values at one stamp; NaN where one is not known."""

    def __init__(
        self,
        wheel_speed: float,
        torque: float,
        demand: float,
        others: Sequence[float] = (),
        slip: float = nan,
        slip_stddev: float = nan,
        car_speed: float = nan,
        car_speed_stddev: float = nan,
        car_speed_measured: bool = False,
        inertial: bool = True,
        in_curve: bool = False,
        slip_text: str = "slip is not known",
    ) -> None:
        """Hold the values.

        Args:
            wheel_speed: [rad/s].
            torque: of the brake, measured [N m].
            demand: of the driver [N m].
            others: circumferential speeds of the other wheels, those that are known [m/s].
            slip: [-].
            slip_stddev: [-].
            car_speed: [m/s].
            car_speed_stddev: [m/s].
            car_speed_measured: whether a speed sensor is in that speed.
            inertial: whether an accelerometer or a speed sensor is in it; else it comes from the wheels alone.
            in_curve: whether the car is in a curve.
            slip_text: why the slip is not known.
        """
        self.wheel_speed = wheel_speed
        self.torque = torque
        self.demand = demand
        self.others = others
        self.slip = slip
        self.slip_stddev = slip_stddev
        self.car_speed = car_speed
        self.car_speed_stddev = car_speed_stddev
        self.car_speed_measured = car_speed_measured
        self.inertial = inertial
        self.in_curve = in_curve
        self.slip_text = slip_text
