"""Samples of a car, and which of them may enter a fit."""

from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from friction_curve_id.interface import Refusal
from friction_curve_id.stamp_order import Admission, StampOrder
from vehicle_models.physical_bounds import HIGHEST_PRESSURE, HIGHEST_SPEED
from vehicle_models.reason import Reason
from vehicle_models.rolling_radius import RollingRadius
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_HARDEST_SHOCK = 50.0
"""A larger reading [m/s^2] is a kerb and not the car (HIGHEST_ACCELERATION lets these pass): in one sample it moves the
speed of a fit by five times the deviation that the fit has for it. The sample is left out."""


class CarSample(NamedTuple):
    """One sample of all W wheels. NaN stands for what is missing; anything may be garbage."""

    time: float
    """Stamp [s]."""
    wheel_speed: ArrayLike
    """Wheel speeds [rad/s], shape (W,)."""
    brake_pressure: ArrayLike
    """Pressures [Pa], shape (W,)."""
    acceleration: float
    """Reading of the accelerometer, forward positive, without any correction [m/s^2]."""
    leftward: float = nan
    """Lateral acceleration, to the left [m/s^2]."""
    yaw_rate: float = nan
    """Counter-clockwise [rad/s]."""


class Checked(NamedTuple):
    """A sample that may enter."""

    time: float
    wheel_speed: Array
    """As on the radii at rest, shape (W,), NaN where the wheel is not measured."""
    brake_pressure: Array
    """Shape (W,), NaN where the wheel is not measured."""
    acceleration: float
    """NaN where missing."""
    after_gap: bool
    """Whether it is the first, or follows a gap."""
    leftward: float = nan
    """NaN where missing, or where the yaw rate is."""
    yaw_rate: float = nan
    """NaN where missing, or where the lateral acceleration is."""


class CarGate:
    """Admits samples one by one, see StampOrder for their stamps."""

    def __init__(self, vehicle: Vehicle, max_gap: float) -> None:
        """Take the car; `max_gap` [s]."""
        self._names, self._radii = vehicle.wheel_names, np.array(vehicle.radii)
        self._rolling = RollingRadius(vehicle)
        self._order = StampOrder(max_gap)
        self._time = -inf

    def reset(self) -> None:
        """Forget the stamps seen."""
        self._order.reset()
        self._time = -inf

    def admit(self, sample: CarSample) -> Checked | Refusal:
        """Return the sample as numbers, or why it must not enter."""
        try:
            time, acceleration = float(sample.time), float(sample.acceleration)
            leftward, yaw_rate = float(sample.leftward), float(sample.yaw_rate)
            speed = np.array(sample.wheel_speed, dtype=np.float64)
            pressure = np.array(sample.brake_pressure, dtype=np.float64)
        except (TypeError, ValueError):
            return Refusal(Reason.BAD_INPUT, "the sample is not made of numbers")
        if not isfinite(time):
            return Refusal(Reason.BAD_INPUT, f"time is {time}")
        if speed.shape != self._radii.shape or pressure.shape != self._radii.shape:
            return Refusal(Reason.BAD_INPUT, f"a sample holds {self._radii.size} wheel speeds and brake pressures")
        refusal = self._implausible(speed, pressure, acceleration)
        if refusal is not None:
            return refusal
        admission = self._order.admit(time)
        if isinstance(admission, Refusal):
            return admission
        missing = ~(np.isfinite(speed) & np.isfinite(pressure))
        speed[missing] = pressure[missing] = np.nan
        if not (abs(leftward) <= _HARDEST_SHOCK and isfinite(yaw_rate)):
            leftward = yaw_rate = nan
        after_gap = admission is not Admission.NEXT
        along, across = (each if isfinite(each) else 0.0 for each in (acceleration, leftward))
        speed *= self._rolling.update(time - self._time, along, across)[0]
        self._time = time
        return Checked(time, speed, np.maximum(pressure, 0.0), acceleration, after_gap, leftward, yaw_rate)

    def _implausible(self, speed: Array, pressure: Array, acceleration: float) -> Refusal | None:
        for name, radius, omega, each in zip(self._names, self._radii, speed, pressure, strict=True):
            if np.isinf(omega) or omega * radius > HIGHEST_SPEED or omega < -1.0:
                return Refusal(Reason.BAD_INPUT, f"wheel speed of {name} is {omega} rad/s")
            if np.isinf(each) or abs(each) > HIGHEST_PRESSURE:
                return Refusal(Reason.BAD_INPUT, f"brake pressure of {name} is {each} Pa")
        if np.isinf(acceleration) or abs(acceleration) > _HARDEST_SHOCK:
            return Refusal(Reason.BAD_INPUT, f"acceleration is {acceleration} m/s^2")
        return None
