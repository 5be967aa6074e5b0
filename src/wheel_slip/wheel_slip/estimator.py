"""Slip of every wheel of a car from wheel speeds, acceleration and, when there is one, a speed sensor."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan, sqrt

from wheel_slip.estimate import Reason, SpeedSource, WheelEstimate
from wheel_slip.slip import slip, slip_rate, slip_rate_variance, slip_variance
from wheel_slip.vehicle_speed import SpeedSample, VehicleSpeed, VehicleSpeedParameters
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
        radii = self._p.radii
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
        return [self._estimate(index, measured) for index, measured in enumerate(wheel_speeds)]

    def _estimate(self, index: int, measured: float) -> WheelEstimate:
        wheel, speed = self._wheels[index], self.vehicle.filter
        known = self.vehicle.source is not SpeedSource.NONE
        base = WheelEstimate(
            vehicle_speed=speed.speed if known else nan,
            vehicle_speed_variance=self.vehicle.variance if known else nan,
            wheel_speed=wheel.speed,
            source=self.vehicle.source,
        )
        reason, text = self._refusal(index, measured)
        if reason is not Reason.OK:
            return replace(base, reason=reason, reason_text=text)
        radius = self._p.radii[index]
        variance = slip_variance(speed.speed, self.vehicle.variance, wheel.speed, wheel.speed_variance, radius)
        if variance > self._p.max_slip_stddev**2:
            text = f"standard deviation of the slip is {sqrt(variance):.3f}"
            return replace(base, reason=Reason.UNCERTAIN, reason_text=text)
        return replace(
            base,
            slip=slip(speed.speed, wheel.speed, radius),
            slip_rate=slip_rate(speed.speed, speed.acceleration, wheel.speed, wheel.acceleration, radius),
            slip_variance=variance,
            slip_rate_variance=slip_rate_variance(
                (speed.speed, self.vehicle.variance),
                (speed.acceleration, speed.acceleration_variance),
                (wheel.speed, wheel.speed_variance),
                (wheel.acceleration, wheel.acceleration_variance),
                radius,
            ),
        )

    def _refusal(self, index: int, measured: float) -> tuple[Reason, str]:
        """Why there is no slip, before its variance is known."""
        wheel = self._wheels[index]
        if not isfinite(measured):
            return Reason.BAD_INPUT, "wheel speed is missing or not finite"
        if not wheel.settled:
            if wheel.restarted_by_gap:
                return Reason.GAP, "wheel speed had a gap"
            return Reason.NOT_READY, "too few samples since start"
        if self.vehicle.source is SpeedSource.NONE:
            return Reason.NO_SPEED, "no vehicle speed"
        if self.vehicle.filter.speed < self._p.minimum_speed:
            return Reason.LOW_SPEED, f"vehicle speed is below {self._p.minimum_speed} m/s"
        return Reason.OK, ""
