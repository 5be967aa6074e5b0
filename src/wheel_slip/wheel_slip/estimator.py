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
        self._largest_variance = parameters.max_slip_stddev**2
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
        rim_speeds: list[float] = []
        smooth_rim_speeds: list[float] = []
        rim_accelerations: list[float] = []
        for wheel, measured, radius in zip(self._wheels, wheel_speeds, radii, strict=True):
            known = isfinite(measured)
            if known:
                wheel.update(stamp, measured)
            rim_speeds.append(measured * radius)
            smooth_rim_speeds.append(wheel.speed * radius if known else nan)
            rim_accelerations.append(wheel.acceleration * radius)
        self.vehicle.update(stamp, rim_speeds, smooth_rim_speeds, rim_accelerations, acceleration, measured_speeds)
        car = self._motion()
        return [
            self._estimate(wheel, measured, radius, car)
            for wheel, measured, radius in zip(self._wheels, wheel_speeds, radii, strict=True)
        ]

    def _motion(self) -> "_Motion":
        """Motion of the car, and why it gives no wheel a slip, if so."""
        vehicle, lowest = self.vehicle, self._p.minimum_speed
        source, state = vehicle.source, vehicle.filter
        if source is SpeedSource.NONE:
            text = "no vehicle speed: no sensor, and the wheels have not shown to roll yet"
            return _Motion((nan, nan), (nan, nan), source, Reason.NO_SPEED, text)
        speed, acceleration = (state.speed, vehicle.variance), (state.acceleration, state.acceleration_variance)
        if state.speed < lowest:
            text = f"vehicle speed is below {lowest} m/s"
            return _Motion(speed, acceleration, source, Reason.LOW_SPEED, text)
        return _Motion(speed, acceleration, source, Reason.OK, "")

    def _estimate(self, wheel: WheelSpeedFilter, measured: float, radius: float, car: "_Motion") -> WheelEstimate:
        car_speed, car_acceleration, source, reason, text = car
        omega = (wheel.speed, wheel.speed_variance)
        slip_found = rate = variance = rate_variance = nan
        if not isfinite(measured):
            reason, text = Reason.BAD_INPUT, "wheel speed is missing or not finite"
        elif not wheel.settled:
            if wheel.restarted_by_gap:
                reason, text = Reason.GAP, "wheel speed had a gap"
            else:
                reason, text = Reason.NOT_READY, "too few samples since start"
        elif reason is Reason.OK:
            variance = slip_variance(car_speed[0], car_speed[1], omega[0], omega[1], radius)
            if variance > self._largest_variance:
                reason, text = Reason.UNCERTAIN, f"standard deviation of the slip is {sqrt(variance):.3f}"
                variance = nan
            else:
                omega_dot = (wheel.acceleration, wheel.acceleration_variance)
                slip_found = slip(car_speed[0], omega[0], radius)
                rate = slip_rate(car_speed[0], car_acceleration[0], omega[0], omega_dot[0], radius)
                rate_variance = slip_rate_variance(car_speed, car_acceleration, omega, omega_dot, radius)
        return WheelEstimate(
            slip_found, rate, car_speed[0], omega[0], variance, rate_variance, car_speed[1], source, reason, text
        )


class _Motion(NamedTuple):
    """Of the car at one stamp: (value, variance) of speed [m/s] and acceleration [m/s^2], and why they give no slip."""

    speed: tuple[float, float]
    acceleration: tuple[float, float]
    source: SpeedSource
    reason: Reason
    reason_text: str
