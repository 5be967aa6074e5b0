"""Slip of every wheel of a car from wheel speeds, acceleration and, where they are there, yaw rate and speed sensor."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_parameters.parameter import group, max_gap_parameter, minimum_speed_parameter, parameter
from sensor_monitor.frozen_wheel import DEAD, STUCK, FrozenWheels
from sensor_monitor.signal_noise import MORE, SignalNoise
from sensor_monitor.unit_check import UnitCheck
from sensor_monitor.wheel_noise import WheelNoise
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_SLIP, is_vague
from vehicle_models.reason import Reason
from vehicle_models.rolling_radius import RollingRadius
from vehicle_models.vehicle import Vehicle
from wheel_slip.car_motion import CarMotion, WheelMotion
from wheel_slip.estimate import (
    Hypotheses,
    SpeedSample,
    WheelEstimate,
    slip,
    slip_rate,
    slip_rate_variance,
    slip_variance,
)
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.prediction import MISREAD, MISTOLD, SLOPE_CHANGED
from wheel_slip.speed_sensor import SpeedSensor
from wheel_slip.wheel_speed_filter import WheelFilterParameters, WheelSpeedFilter

Array = NDArray[np.float64]

_FAULTS = {
    STUCK: (Reason.WHEEL_SENSOR, "wheel speed repeats itself while the others change: stuck"),
    DEAD: (Reason.WHEEL_SENSOR, "wheel speed falls to zero at once, as no brake can cause: dead"),
}
"""What is said of a wheel by what is wrong with its sensor."""


@dataclass(frozen=True)
class EstimatorParameters:
    """When there is a slip, and the parameters of the filter of a wheel."""

    minimum_speed: float = minimum_speed_parameter(1.0)
    max_gap: float = max_gap_parameter(0.1)
    max_slip_stddev: float = parameter(
        0.2, "slip is UNCERTAIN above this standard deviation", minimum=1e-3, maximum=1.0
    )
    wheel_filter: WheelFilterParameters = group(WheelFilterParameters())


class SlipEstimator:
    """Slip estimator of one car. `update` takes all that is known at one stamp."""

    def __init__(self, vehicle: Vehicle, parameters: EstimatorParameters = EstimatorParameters()) -> None:
        """Start without samples."""
        self._p = parameters
        p = parameters.wheel_filter
        self._names = vehicle.wheel_names
        self._wheels = [WheelSpeedFilter(p, parameters.max_gap, each.encoder_teeth) for each in vehicle.wheels]
        self._at_rest, self._rolling = np.array(vehicle.radii), RollingRadius(vehicle)
        self._units = UnitCheck(float(self._at_rest.mean()))
        self._frozen = FrozenWheels()
        self._noise = WheelNoise(p.speed_stddev**2)
        self.car = CarMotion(vehicle, p.speed_stddev)
        """Motion of the car."""
        self.speed_sensor = SpeedSensor()
        """What is known of the speed sensor."""
        self._ordinary = MotionNoise().acceleration ** 2
        self._accelerometer_noise = SignalNoise(self._ordinary, self._ordinary)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        for wheel in self._wheels:
            wheel.reset()
        self._units.reset()
        self._noise.reset()
        self._know_noise()
        self._frozen.reset()
        self.car.reset()
        self.speed_sensor.reset()
        self._accelerometer_noise.reset()
        self._read = False
        self._stamp = 0

    def update(
        self,
        stamp: int,
        wheel_speeds: Sequence[float],
        acceleration: float | None,
        measured_speeds: Sequence[SpeedSample] = (),
        torques: Sequence[float] = (),
        yaw_rate: float | None = None,
    ) -> list[WheelEstimate]:
        """Take one sample and estimate at its stamp.

        Args:
            stamp: stamp of the wheel speeds [ns], later than the last.
            wheel_speeds: speed of each wheel [rad/s]; not finite where it is missing.
            acceleration: acceleration of the car at the stamp [m/s^2], forward positive; None if there is none.
            measured_speeds: samples of the speed sensor that became known since the last update.
            torques: of the brakes [N m], NaN where unknown; empty where no brake is known.
            yaw_rate: of the car at the stamp [rad/s], counter-clockwise positive; None if there is none.

        Returns:
            One estimate per wheel.
        """
        since, self._stamp = (stamp - self._stamp) / NANOSECONDS if self._stamp else inf, stamp
        seen = [isfinite(measured) for measured in wheel_speeds]
        for wheel, measured, known in zip(self._wheels, wheel_speeds, seen, strict=True):
            if known:
                wheel.update(stamp, measured)
        reading = acceleration if acceleration is not None and isfinite(acceleration) else None
        turned = yaw_rate if yaw_rate is not None and isfinite(yaw_rate) else None
        # Where nothing measures a curve, what the wheels show of it has their radii in it.
        leftward = turned * self.car.speed if turned is not None and self.car.started else 0.0
        loaded, doubt = self._rolling.update(since, self.car.acceleration if reading is None else reading, leftward)
        wheels = list(zip(self._wheels, wheel_speeds, (self._at_rest * loaded).tolist(), seen, strict=True))
        rims = [omega * radius if known and not wheel.in_gap else nan for wheel, omega, radius, known in wheels]
        frozen = self._frozen.update(stamp, rims, nan if reading is None else self.car.travelled)
        if reading is not None:
            self._read = True
            self._accelerometer_noise.update(stamp, reading)
            noisy = self._accelerometer_noise.variance > MORE * self._ordinary
            self.car.set_drift(self._accelerometer_noise.drift if noisy else 0.0)
        self._watch_noise(stamp, wheel_speeds)
        rolling = [nan if wrong else rim for rim, wrong in zip(rims, frozen, strict=True)]
        self.car.update(stamp, rolling, reading, torques, turned, doubt)
        self.speed_sensor.follow(stamp, self.car)
        for sample in measured_speeds:
            self.speed_sensor.update(sample, self.car)
        smooth = [wheel.speed * radius if known else nan for wheel, _, radius, known in wheels]
        rates = [wheel.acceleration * radius for wheel, _, radius, _ in wheels]
        self._units.update(stamp, smooth, rates, reading, measured_speeds[-1].speed if measured_speeds else None)
        of_car = self._known()
        return [
            self._estimate(wheel, known, motion, _FAULTS.get(wrong, of_car))
            for (wheel, _, _, known), motion, wrong in zip(wheels, self._motions(loaded, doubt), frozen, strict=True)
        ]

    @property
    def hypotheses(self) -> Hypotheses:
        """Probabilities of what may be the matter with road and sensors."""
        changed, misread, mistold = self.car.probabilities[[SLOPE_CHANGED, MISREAD, MISTOLD]].tolist()
        return Hypotheses(
            changed,
            misread if self._read else nan,
            mistold if self.car.knows_torques else nan,
            self.speed_sensor.wrong(self._stamp),
        )

    @property
    def accelerometer_text(self) -> str:
        """Names what is wrong with the accelerometer, empty where nothing is."""
        if not self.hypotheses.accelerometer_wrong > 0.5:
            return ""
        return "reads another motion than the wheels: late, turned or stuck?"

    @property
    def pressure_text(self) -> str:
        """Names what is wrong with the brake pressures, empty where nothing is."""
        if not self.hypotheses.pressures_wrong > 0.5:
            return ""
        return "the car brakes harder than they do: one reads too little, or a brake's gain is wrong"

    @property
    def radius_text(self) -> str:
        """Names the wheels that rather have another tyre than the vehicle file's, empty where none does."""
        errors, _ = self.car.radius_errors
        return "; ".join(
            f"{name}: its radius is {100.0 * abs(error):.1f} % {'below' if error < 0.0 else 'above'} that of the "
            "vehicle file: another tyre, worn or flat? It is corrected"
            for name, error, other in zip(self._names, errors, self.car.another_tyre, strict=True)
            if other > 0.5
        )

    def _watch_noise(self, stamp: int, wheel_speeds: Sequence[float]) -> None:
        """Use the noise that wheels show which roll without force, from this sample on."""
        before = self._noise.variance
        felt = self.car.travelled / float(self._at_rest[0]) if self._read else nan
        self._noise.update(stamp, wheel_speeds, self.car.started and self.car.is_forceless, felt)
        if self._noise.variance != before:
            self._know_noise()

    def _know_noise(self) -> None:
        for wheel in self._wheels:
            wheel.know_noise(self._noise.variance, self._noise.lasting)
        self.car.set_noise(self._noise.variance)

    def _motions(self, loaded: Array, doubt: Array) -> list[WheelMotion]:
        """Return the motion of every wheel on the radius that it has under its load; arguments as of RollingRadius."""
        found = []
        for index, (share, stddev) in enumerate(zip(loaded.tolist(), doubt.tolist(), strict=True)):
            motion = self.car.wheel(index)
            variance = motion.radius_variance + stddev**2
            found.append(motion._replace(radius=motion.radius * share, radius_variance=variance))
        return found

    def _known(self) -> tuple[Reason, str]:
        """Return whether the motion of the car gives a slip: the reason where it gives none, and that in words."""
        car = self.car
        if self._units.text:
            return Reason.BAD_INPUT, self._units.text
        if not car.started:
            return Reason.NO_SPEED, "waiting for wheel speeds or a speed sensor"
        stddev = sqrt(car.variance + self.speed_sensor.undecided)
        if is_vague(car.speed, stddev):
            return Reason.UNCERTAIN, f"waiting for a rolling wheel: speed deviation {stddev:.1f} m/s"
        if car.speed < self._p.minimum_speed:
            return Reason.LOW_SPEED, f"waiting for a speed above {self._p.minimum_speed} m/s"
        return Reason.OK, ""

    def _estimate(
        self, wheel: WheelSpeedFilter, measured: bool, motion: WheelMotion, known: tuple[Reason, str]
    ) -> WheelEstimate:
        car, (reason, text), radius = self.car, known, motion.radius
        omega = (
            wheel.speed + wheel.age * wheel.acceleration,
            wheel.speed_variance + wheel.lag_variance + wheel.age_variance + wheel.lasting_variance,
        )
        unknown = not car.started or bool(self._units.text)
        speed = (nan, nan) if unknown else (motion.ground, motion.ground_variance + self.speed_sensor.undecided)
        if not measured:
            reason, text = Reason.BAD_INPUT, "wheel speed is missing or not finite"
        elif not wheel.settled and wheel.restarted_by_gap:
            reason, text = Reason.GAP, "wheel speed had a gap: waiting for new samples"
        elif not wheel.settled:
            reason, text = Reason.NOT_READY, "waiting for the first samples"
        elif reason is Reason.OK:
            found = slip(speed[0], omega[0], radius)
            variance = slip_variance(speed, omega, (radius, motion.radius_variance), motion.covariance)
            by_failure = motion.failed / max(abs(speed[0]), self._p.minimum_speed) ** 2
            if variance > self._p.max_slip_stddev**2:
                reason, text = Reason.UNCERTAIN, f"waiting for more speed: slip deviation {sqrt(variance):.3f}"
            elif abs(found) > HIGHEST_SLIP:
                reason, text = Reason.BAD_INPUT, f"slip of {found:.2f}: the wheel spins, or the speed is wrong"
            elif variance + by_failure > self._p.max_slip_stddev**2:
                reason, text = Reason.WHEEL_SENSOR, "wheel speed is unlike its force: wrong, or the wheel spins"
            variance += by_failure
        if reason is not Reason.OK:
            return WheelEstimate(nan, nan, speed[0], omega[0], nan, nan, speed[1], reason, text)
        acceleration, omega_dot = (
            (car.acceleration, car.acceleration_variance),
            (wheel.acceleration, wheel.acceleration_variance + wheel.lasting_variance * wheel.speed**2),
        )
        rate = slip_rate(speed[0], acceleration[0], omega[0], omega_dot[0], radius)
        rate_variance = slip_rate_variance(speed, acceleration, omega, omega_dot, radius)
        return WheelEstimate(found, rate, speed[0], omega[0], variance, rate_variance, speed[1], reason, text)
