"""Slip of every wheel of a car from wheel speeds, acceleration and, when there is one, a speed sensor."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import NamedTuple

from wheel_slip.estimate import Reason, SpeedSource, WheelEstimate
from wheel_slip.online_radii import OnlineRadii
from wheel_slip.slip import slip, slip_rate, slip_rate_variance, slip_variance
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.vehicle_speed import VehicleSpeed, VehicleSpeedParameters
from wheel_slip.wheel_speed_filter import WheelSpeedFilter


@dataclass(frozen=True)
class EstimatorParameters:
    """Of one car."""

    radii: tuple[float, ...]
    """Effective rolling radius of each wheel [m]."""
    driven: tuple[bool, ...]
    """Which wheels the engine drives; none, where that is not known or all are."""
    vehicle_speed: VehicleSpeedParameters
    wheel_speed_stddev: float = 0.07
    """Noise of a wheel speed [rad/s]."""
    wheel_jerk_density: float = 3e3
    """[rad^2/s^5], see wheel_speed_filter."""
    minimum_speed: float = 1.0
    """No slip below this vehicle speed [m/s]."""
    max_gap: float = 0.1
    """Longer gaps of wheel speeds [s] start the wheel's filter anew."""
    max_slip_stddev: float = 0.07
    """No slip where its standard deviation is larger [-]."""
    learn_radii: bool = False
    """Calibrate the radii while the car coasts, and use them."""


class SlipEstimator:
    """One car. `update` takes all that is known at one stamp."""

    def __init__(self, parameters: EstimatorParameters) -> None:
        """Start anew."""
        self._p = parameters
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        p = self._p
        self._wheels = [WheelSpeedFilter(p.wheel_speed_stddev**2, p.wheel_jerk_density, p.max_gap) for _ in p.radii]
        self.vehicle = VehicleSpeed(p.vehicle_speed, p.driven)
        self.radii = p.radii
        """In use [m]: the parameters, or what has been learned."""
        self._online = OnlineRadii(p.radii) if p.learn_radii else None

    def update(
        self,
        stamp: int,
        wheel_speeds: Sequence[float],
        acceleration: float | None,
        measured_speeds: Sequence[SpeedSample] = (),
    ) -> list[WheelEstimate]:
        """Take one sample and estimate at its stamp.

        Args:
            stamp: of the wheel speeds [ns], later than the last.
            wheel_speeds: of each wheel [rad/s]; not finite where it is missing.
            acceleration: of the car at the stamp [m/s^2], forward positive; None if there is none.
            measured_speeds: samples of the speed sensor that became known since the last update.

        Returns:
            One estimate a wheel.
        """
        if self._online is not None:
            self.radii = self._online.update(stamp, wheel_speeds, measured_speeds)
        radii = self.radii
        for wheel, measured in zip(self._wheels, wheel_speeds, strict=True):
            if isfinite(measured):
                wheel.update(stamp, measured)
        self.vehicle.update(
            stamp,
            [speed * radius for speed, radius in zip(wheel_speeds, radii, strict=True)],
            [
                wheel.speed * radius if isfinite(speed) else nan
                for wheel, speed, radius in zip(self._wheels, wheel_speeds, radii, strict=True)
            ],
            [wheel.acceleration * radius for wheel, radius in zip(self._wheels, radii, strict=True)],
            acceleration,
            measured_speeds,
        )
        car = self._motion()
        return [self._estimate(index, measured, car) for index, measured in enumerate(wheel_speeds)]

    def _motion(self) -> "_Motion":
        vehicle = self.vehicle
        if vehicle.source is SpeedSource.NONE:
            return _Motion((nan, nan), (nan, nan), SpeedSource.NONE)
        state = vehicle.filter
        speed, acceleration = (state.speed, vehicle.variance), (state.acceleration, state.acceleration_variance)
        return _Motion(speed, acceleration, vehicle.source)

    def _estimate(self, index: int, measured: float, car: "_Motion") -> WheelEstimate:
        wheel, radius = self._wheels[index], self.radii[index]
        estimate = WheelEstimate(
            vehicle_speed=car.speed[0],
            vehicle_speed_variance=car.speed[1],
            wheel_speed=wheel.speed,
            source=car.source,
        )
        estimate.reason, estimate.reason_text = self._refusal(index, measured, car)
        if estimate.reason is not Reason.OK:
            return estimate
        speed, speed_variance = car.speed
        variance = slip_variance(speed, speed_variance, wheel.speed, wheel.speed_variance, radius)
        if variance > self._p.max_slip_stddev**2:
            estimate.reason = Reason.UNCERTAIN
            estimate.reason_text = f"standard deviation of the slip is {sqrt(variance):.3f}"
            return estimate
        estimate.slip = slip(speed, wheel.speed, radius)
        estimate.slip_variance = variance
        estimate.slip_rate = slip_rate(speed, car.acceleration[0], wheel.speed, wheel.acceleration, radius)
        estimate.slip_rate_variance = slip_rate_variance(
            car.speed,
            car.acceleration,
            (wheel.speed, wheel.speed_variance),
            (wheel.acceleration, wheel.acceleration_variance),
            radius,
        )
        return estimate

    def _refusal(self, index: int, measured: float, car: "_Motion") -> tuple[Reason, str]:
        """Why there is no slip, before its variance is known."""
        wheel = self._wheels[index]
        if not isfinite(measured):
            return Reason.BAD_INPUT, "wheel speed is missing or not finite"
        if not wheel.settled:
            if wheel.restarted_by_gap:
                return Reason.GAP, "wheel speed had a gap"
            return Reason.NOT_READY, "too few samples since start"
        if car.source is SpeedSource.NONE:
            return Reason.NO_SPEED, "no vehicle speed: no sensor, and the wheels have not shown to roll yet"
        if car.speed[0] < self._p.minimum_speed:
            return Reason.LOW_SPEED, f"vehicle speed is below {self._p.minimum_speed} m/s"
        return Reason.OK, ""


class _Motion(NamedTuple):
    """Of the car at one stamp: (value, variance) of speed [m/s] and acceleration [m/s^2]."""

    speed: tuple[float, float]
    acceleration: tuple[float, float]
    source: SpeedSource
