"""Slip of every wheel of a car from wheel speeds, acceleration and, when there is one, a speed sensor."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import NamedTuple

from friction_parameters.parameter import constants, group, max_gap_parameter, minimum_speed_parameter, parameter
from vehicle_models.physical_bounds import HIGHEST_SLIP, is_vague
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimate import Mode, WheelEstimate
from wheel_slip.free_rolling import FreeRolling
from wheel_slip.online_radii import OnlineRadii
from wheel_slip.radius_calibration import Radii
from wheel_slip.relative_radii import RelativeRadii
from wheel_slip.slip import slip, slip_rate, slip_rate_variance, slip_variance
from wheel_slip.speed_filter import AccelerometerParameters
from wheel_slip.speed_sample import SpeedSample
from wheel_slip.tuning import Tuning
from wheel_slip.unit_check import UnitCheck
from wheel_slip.vehicle_speed import VehicleSpeed
from wheel_slip.wheel_noise import WheelNoise
from wheel_slip.wheel_speed_filter import WheelFilterParameters, WheelSpeedFilter


@dataclass(frozen=True)
class EstimatorParameters:
    """When there is a slip, and the parameters of the filters below it."""

    minimum_speed: float = minimum_speed_parameter(1.0)
    max_gap: float = max_gap_parameter(0.1)
    max_slip_stddev: float = parameter(
        0.2, "slip is UNCERTAIN above this standard deviation", minimum=1e-3, maximum=1.0
    )
    learn_radii: bool = parameter(
        False, "calibrate the radii against vehicle_velocity while the car coasts, and use them"
    )
    wheel_filter: WheelFilterParameters = group(WheelFilterParameters())
    accelerometer: AccelerometerParameters = group(AccelerometerParameters())
    speed_timeout: float = parameter(
        0.5, "silence of vehicle_velocity after which it is no longer used", unit="s", minimum=0.01, maximum=10.0
    )
    tuning: Tuning = constants(Tuning())


class SlipEstimator:
    """Slip estimator of one car. `update` takes all that is known at one stamp."""

    def __init__(self, vehicle: Vehicle, parameters: EstimatorParameters = EstimatorParameters()) -> None:
        """Start without samples."""
        self._car = vehicle
        self._p = parameters
        self._relative = RelativeRadii(vehicle)
        self._free = FreeRolling()
        self._units = UnitCheck(sum(vehicle.radii) / len(vehicle.radii))
        self._largest_variance = parameters.max_slip_stddev**2
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        p = self._p
        self._units.reset()
        self._wheels = [WheelSpeedFilter(p.wheel_filter, p.max_gap, each.encoder_teeth) for each in self._car.wheels]
        self.vehicle = VehicleSpeed(self._car, p.tuning, p.accelerometer, p.wheel_filter.speed_stddev, p.speed_timeout)
        self._noise = WheelNoise(p.wheel_filter.speed_stddev**2)
        self._relative.reset()
        self._free.reset()
        self.radii = self._car.radii
        """Radii in use [m]: those of the vehicle file as far as the wheels agree with it, or calibrated ones."""
        self.radius_variances: Sequence[float] = self._relative.variances
        """Variances of the radii relative to their mean, as shares [-]."""
        self._online = OnlineRadii(self.radii) if p.learn_radii else None
        self._calibrated: Radii | None = None

    def update(
        self,
        stamp: int,
        wheel_speeds: Sequence[float],
        acceleration: float | None,
        measured_speeds: Sequence[SpeedSample] = (),
        torques: Sequence[float] = (),
    ) -> list[WheelEstimate]:
        """Take one sample and estimate at its stamp.

        Args:
            stamp: stamp of the wheel speeds [ns], later than the last.
            wheel_speeds: speed of each wheel [rad/s]; not finite where it is missing.
            acceleration: acceleration of the car at the stamp [m/s^2], forward positive; None if there is none.
            measured_speeds: samples of the speed sensor that became known since the last update.
            torques: of the brakes [N m], NaN where unknown; empty where no brake is known.

        Returns:
            One estimate per wheel.
        """
        if self._online is not None:
            calibrated = self._online.update(stamp, wheel_speeds, measured_speeds)
            if calibrated is not None and calibrated is not self._calibrated:
                self._use_calibrated(calibrated)
        radii = self.radii
        rim_speeds: list[float] = []
        smooth_rim_speeds: list[float] = []
        rim_accelerations: list[float] = []
        for wheel, measured, radius in zip(self._wheels, wheel_speeds, radii, strict=True):
            known = isfinite(measured)
            if known:
                wheel.update(stamp, measured)
            rim_speeds.append(nan if wheel.in_gap else measured * radius)
            smooth_rim_speeds.append(wheel.speed * radius if known else nan)
            rim_accelerations.append(wheel.acceleration * radius)
        self._watch_noise(stamp, wheel_speeds, smooth_rim_speeds)
        self.vehicle.update(
            stamp, rim_speeds, smooth_rim_speeds, rim_accelerations, acceleration, measured_speeds, torques
        )
        newest = measured_speeds[-1].speed if measured_speeds else None
        in_use = None if self.vehicle.accelerometer_text else acceleration
        self._units.update(stamp, smooth_rim_speeds, rim_accelerations, in_use, newest)
        car = self._motion()
        self._learn_radii(stamp, smooth_rim_speeds, acceleration)
        return [
            self._estimate(wheel, measured, radius, car, unlike, radius_variance)
            for wheel, measured, radius, unlike, radius_variance in zip(
                self._wheels, wheel_speeds, radii, self._unlike(smooth_rim_speeds), self.radius_variances, strict=True
            )
        ]

    def _watch_noise(self, stamp: int, wheel_speeds: Sequence[float], smooth_rim_speeds: Sequence[float]) -> None:
        """Use the noise that wheels show which turn alike and no brake cycles, from this sample on."""
        before = self._noise.variance
        steady = self.vehicle.is_unbraked and not any([wheel.in_gap for wheel in self._wheels])
        alike = steady and self._p.tuning.slide.are_alike(sorted(smooth_rim_speeds))
        self._noise.update(stamp, wheel_speeds, alike)
        if self._noise.variance != before:
            for wheel in self._wheels:
                wheel.know_noise(self._noise.variance)
            self.vehicle.know_noise(self._noise.variance)

    def _learn_radii(self, stamp: int, smooth_rim_speeds: Sequence[float], acceleration: float | None) -> None:
        """Learn from the next stretch without force; the radii are used from the next sample on."""
        if self._calibrated is not None:
            return
        stretch = self._free.update(stamp, smooth_rim_speeds, acceleration, self.vehicle.offset, self._p.max_gap)
        if stretch is None:
            return
        with_file = [
            speed * nominal / radius
            for speed, nominal, radius in zip(stretch.rim_speeds, self._car.radii, self.radii, strict=True)
        ]
        self._relative.update(stretch._replace(rim_speeds=with_file))
        self.radii, self.radius_variances = self._relative.radii, self._relative.variances
        self.vehicle.radii.know(self.vehicle.radii.common, self._relative.covariance)

    def _use_calibrated(self, found: Radii) -> None:
        """Take radii and deviations of the calibration in place of what the vehicle file says."""
        self._calibrated, self.radii = found, found.radii
        shares = [stddev / radius for stddev, radius in zip(found.stddevs, found.radii, strict=True)]
        self.radius_variances = [share**2 for share in shares]
        # The speed sensor's own error of scale is in all of them alike, and not known.
        self.vehicle.radii.know(max(shares), [[0.0] * len(shares)] * len(shares))

    @property
    def radius_text(self) -> str:
        """Names the wheels whose radius is far from the vehicle file's, empty where none is."""
        return "" if self._calibrated is not None else self._relative.text

    def _unlike(self, rim_speeds: Sequence[float]) -> list[float]:
        """Return how far each wheel is from the mean of all [m/s] while they roll: by curves, radii or slip."""
        known = [speed for speed in rim_speeds if isfinite(speed)]
        if self.vehicle.mode is not Mode.ROLLING or not known:
            return [0.0] * len(rim_speeds)
        mean = sum(known) / len(known)
        return [speed - mean if isfinite(speed) else 0.0 for speed in rim_speeds]

    def _motion(self) -> "_Motion":
        """Return the motion of the car, with the reason if no wheel can have a slip."""
        vehicle, lowest = self.vehicle, self._p.minimum_speed
        mode = vehicle.mode
        if self._units.text:
            return _Motion((nan, nan), (nan, nan), nan, Mode.WAITING, Reason.BAD_INPUT, self._units.text)
        if mode is Mode.WAITING:
            text = "no vehicle speed: no sensor, and the wheels have not shown to roll yet"
            return _Motion((nan, nan), (nan, nan), nan, mode, Reason.NO_SPEED, text)
        speed, acceleration = (vehicle.speed, vehicle.variance), (vehicle.acceleration, vehicle.acceleration_variance)
        if is_vague(vehicle.speed, sqrt(vehicle.stated_variance)):
            text = f"standard deviation of the vehicle speed is {sqrt(vehicle.stated_variance):.1f} m/s"
            return _Motion(speed, acceleration, vehicle.stated_variance, mode, Reason.UNCERTAIN, text)
        if vehicle.speed < lowest:
            text = f"vehicle speed is below {lowest} m/s"
            return _Motion(speed, acceleration, vehicle.stated_variance, mode, Reason.LOW_SPEED, text)
        return _Motion(speed, acceleration, vehicle.stated_variance, mode, Reason.OK, "")

    def _estimate(
        self,
        wheel: WheelSpeedFilter,
        measured: float,
        radius: float,
        car: "_Motion",
        unlike: float,
        radius_variance: float,
    ) -> WheelEstimate:
        car_speed, car_acceleration, _, mode, reason, text = car
        omega_variance = wheel.speed_variance + wheel.lag_variance + wheel.age_variance
        omega = (wheel.speed + wheel.age * wheel.acceleration, omega_variance)
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
            of_radius = radius_variance + self.vehicle.radii_against_speed**2
            variance += (unlike / car_speed[0]) ** 2 + (radius * omega[0] / car_speed[0]) ** 2 * of_radius
            if variance > self._largest_variance:
                reason, text = Reason.UNCERTAIN, f"standard deviation of the slip is {sqrt(variance):.3f}"
                variance = nan
            elif abs(slip(car_speed[0], omega[0], radius)) > HIGHEST_SLIP:
                reason, variance = Reason.BAD_INPUT, nan
                text = f"slip of {slip(car_speed[0], omega[0], radius):.2f}: the wheel spins, or the speed is wrong"
            else:
                omega_dot = (wheel.acceleration, wheel.acceleration_variance)
                slip_found = slip(car_speed[0], omega[0], radius)
                rate = slip_rate(car_speed[0], car_acceleration[0], omega[0], omega_dot[0], radius)
                rate_variance = slip_rate_variance(car_speed, car_acceleration, omega, omega_dot, radius)
        return WheelEstimate(
            slip_found, rate, car_speed[0], omega[0], variance, rate_variance, car.stated, mode, reason, text
        )


class _Motion(NamedTuple):
    """Motion of the car at one stamp: (value, variance) of speed [m/s] and acceleration [m/s^2]; why it has no slip."""

    speed: tuple[float, float]
    acceleration: tuple[float, float]
    stated: float
    """Variance of the speed with that of the radii [m^2/s^2]."""
    mode: Mode
    reason: Reason
    text: str
