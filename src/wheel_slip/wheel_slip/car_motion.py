"""Estimates speed, yaw rate, slips and radii of a car, by a Kalman filter for each hypothesis on slope and sensors.

| state | | unit | model |
|---|---|---|---|
| v | speed of the middle of the rear axle, forward positive | m/s | v' = (a_m - b)(1 - k) + (t_0 + t) a_m' + n_a |
| b | offset of the accelerometer and slope of the road | m/s^2 | walks: by `offset_walk`, the slope, or `misread` |
| k | error of the accelerometer's gain: scale, pitch of the body | - | constant |
| u | yaw rate, counter-clockwise positive | rad/s | u' = u_m' - (u - u_m) / T_u + n_u, measured u_m or 0 |
| t | age of the accelerometer beyond that of the vehicle file | s | constant, not estimated |
| f | error of the force of the engine over the mass: bias of the accelerometer, drag | m/s^2 | constant |
| s | slip of tyres beyond their peak, all alike | - | is forgotten in `slide_time` |
| c_i | slip of tyre i over its force, a share of its load times g | s^2/m | constant while the force is |
| e_i | error of the radius of wheel i, as a share | - | constant: with `radius_walk` |

A wheel is measured by one equation, whatever it does (wheel_equation.py). A slip is constant at a constant force and
vanishes with it, so a change that stays is a slope, and the moments of little force of a wheel whose brake cycles tell
the speed. Where a tyre bends, at its peak, the slip creeps at any force, and says little. An age of the accelerometer
looks like slip that grows with the force, so t is only considered.

The hypotheses, and how they and the states go on, are in prediction.py. The wheels correct once in a `step`
(wheel_correction.py); within a step the accelerometer carries the speed.
"""

from collections.abc import Sequence
from math import hypot, nan
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import STANDING
from vehicle_models.vehicle import STATED, Vehicle, absolute_deviation, deviation_of, specified_stddev
from wheel_slip.filter_bank import FilterBank
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.prediction import MISTOLD, PRIOR, Prediction
from wheel_slip.radius_odds import RadiusOdds
from wheel_slip.step import Step
from wheel_slip.tyre_forces import TELLING
from wheel_slip.wheel_correction import WheelCorrection
from wheel_slip.wheel_equation import SLOWEST_TURN, B, C, F, K, S, T, U, V, speed_before

Array = NDArray[np.float64]

_JITTER: Final = 100_000
"""By which stamps may be off their grid [ns]."""


class WheelMotion(NamedTuple):
    """Where a wheel is, and how well that is known."""

    ground: float
    """Speed of the ground at it [m/s]."""
    ground_variance: float
    """[m^2/s^2]"""
    radius: float
    """[m]"""
    radius_variance: float
    """As a share [-]."""
    covariance: float
    """Of ground speed and radius error [m/s]."""
    failed: float
    """Variance of its rim speed, as far as no motion explains it [m^2/s^2]."""


class CarMotion:
    """Motion of one car; nothing is known before `started`."""

    def __init__(self, vehicle: Vehicle, wheel_speed_stddev: float, noise: MotionNoise = MotionNoise()) -> None:
        """Start without samples; `wheel_speed_stddev` is the noise of a wheel speed [rad/s]."""
        self._noise = noise
        wheels, mounting = vehicle.wheels, vehicle.accelerometer
        self._count = len(wheels)
        self._e = C + self._count
        self._radii = np.array(vehicle.radii)
        scale = specified_stddev(mounting.deviations, "scale")
        pitch = GRAVITY * deviation_of(mounting.deviations, "pitch_gain", 0.0)
        gain = noise.gain if scale is None else hypot(scale / mounting.scale, pitch)
        offset = max(noise.offset, deviation_of(mounting.deviations, "bias", 0.0))
        age = absolute_deviation(mounting.deviations, "delay")
        self._delay = mounting.delay
        self._step = Step(self._count)
        self._prediction = Prediction(noise, self._delay, offset)
        self._correction = WheelCorrection(vehicle, noise, offset)
        self.set_noise(wheel_speed_stddev**2)
        stated = [deviation_of(each.deviations, "radius", STATED["radius"] * each.radius) for each in wheels]
        apart = np.array(stated) / self._radii
        prior = np.zeros((C + 2 * self._count,) * 2)
        prior[B, B], prior[K, K], prior[U, U] = offset**2, gain**2, (noise.lateral / SLOWEST_TURN) ** 2
        prior[T, T], prior[F, F] = age**2, noise.pull**2
        prior[S, S] = noise.slide_alike * noise.slide_stddev**2
        alike = noise.compliance_alike
        prior[C : self._e, C : self._e] = noise.compliance_stddev**2 * (alike + (1.0 - alike) * np.eye(self._count))
        self._radius_odds = RadiusOdds(float(apart.max()), 0.5 * apart, noise)
        prior[self._e :, self._e :] = self._radius_odds.prior
        self._prior = prior
        self._expected = np.zeros(C + 2 * self._count)
        self._expected[C : self._e] = noise.compliance
        self._expected[S] = noise.slide
        self._of_yaw = np.zeros((PRIOR.size, C + 2 * self._count))
        self._of_yaw[:, U] = 1.0
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._bank = FilterBank(self._expected, self._prior, PRIOR, T)
        self.started = False
        """Whether there is a speed."""
        self._step.reset()
        self._prediction.reset()
        self._correction.reset()
        self._carried = 0.0
        self._yaw_rate: float | None = None
        self._tell()

    def set_noise(self, variance: float) -> None:
        """Take the variance of a wheel speed [rad^2/s^2]."""
        self._correction.set_noise(variance)

    def set_drift(self, variance: float) -> None:
        """Take the variance that the noise of the accelerometer brings to the speed in a second [m^2/s^3]."""
        self._prediction.set_drift(variance)

    @property
    def probabilities(self) -> Array:
        """Of the hypotheses, shape (4,)."""
        return self._bank.probabilities

    @property
    def knows_torques(self) -> bool:
        """Whether the torques of all brakes are known."""
        return self._correction.odds.known

    @property
    def speed(self) -> float:
        """Speed of the middle of the rear axle [m/s]."""
        return self._speed + self._carried

    @property
    def travelled(self) -> float:
        """Integral of the acceleration as it was felt [m/s], slope and bias included; begins anywhere."""
        return self._step.way - self._correction.misread_way

    @property
    def acceleration(self) -> float:
        """Acceleration along the road [m/s^2]."""
        if self._step.reading is None:
            return self._step.felt
        return float((self._step.reading - self.mean[B]) * (1.0 - self.mean[K]))

    @property
    def acceleration_variance(self) -> float:
        """Variance of it [m^2/s^4]."""
        if self._step.reading is None:
            return self._noise.unknown_acceleration**2
        p = self.covariance
        return float(p[B, B] + self._noise.acceleration**2 + p[K, K] * self.acceleration**2)

    @property
    def is_forceless(self) -> bool:
        """Whether no tyre has a force to speak of, by the accelerometer where there is one: ripple looks like one."""
        reading = self._step.reading
        return (self._correction.largest_force if reading is None else abs(reading)) < TELLING

    @property
    def radius_errors(self) -> tuple[Array, Array]:
        """Errors of the radii as shares, and their standard deviations, shape (wheels,)."""
        return self.mean[self._e :], np.sqrt(np.diagonal(self.covariance)[self._e :])

    def wheel(self, index: int) -> WheelMotion:
        """What a wheel's slip is made of."""
        told = self._wheels[index]
        return told._replace(ground=told.ground + self._carried)

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        reading: float | None,
        torques: Sequence[float] = (),
        yaw_rate: float | None = None,
        radius_doubt: Array | float = 0.0,
    ) -> None:
        """Take one sample.

        Args:
            stamp: of the sample [ns], later than the last.
            rim_speeds: r omega of each wheel as measured [m/s], NaN where missing.
            reading: of the accelerometer, forward positive [m/s^2], None if there is none.
            torques: of the brakes one step ago [N m], NaN where unknown; empty where no brake is known.
            yaw_rate: [rad/s], counter-clockwise positive, None if there is none.
            radius_doubt: standard deviations of the radii under load as shares, shape (wheels,).
        """
        if self._step.pauses(stamp):
            self.reset()
        self._step.add(stamp, rim_speeds, reading, torques, yaw_rate)
        self._carried = self._forward() if self.started else 0.0
        if stamp - self._step.stamp >= self._noise.step * NANOSECONDS - _JITTER:
            self._take_step(stamp, min(self._step.since, 1.0), radius_doubt)

    def compare(self, stamp: int, speed: float) -> tuple[float, float] | None:
        """Return by how much a measured speed [m/s] differs from that at a stamp [ns], and the variance of that.

        None where nothing is known of that time.
        """
        seen = self._back(self.mean, stamp)
        if seen is None:
            return None
        then, h = seen
        return speed - float(then), float(h @ self.covariance @ h) + self._lasting

    def take_speed(self, stamp: int, speed: float, variance: float) -> None:
        """Correct by a speed [m/s] with its variance [m^2/s^2] that was measured at a stamp [ns]; or start at it."""
        if not self.started:
            self._begin_at(speed, variance)
            return
        seen = self._back(self._bank.x, stamp)
        if seen is not None:
            then, h = seen
            self._bank.correct_one(h, speed - then, variance)
            self._tell()

    def _back(self, x: Array, stamp: float) -> tuple[Array, Array] | None:
        """Return the speed at a stamp [ns] by states x, shape (..., states), and its derivatives by them."""
        gone = self._step.gone_since(stamp)
        return None if gone is None else speed_before(x, (self._step.stamp - stamp) / NANOSECONDS, gone)

    def _forward(self) -> float:
        """Return the change of the speed since the last step [m/s]."""
        step = self._step
        return (step.gone - self._bias * step.since) * self._kept + self._delay * step.moved

    def _take_step(self, stamp: int, dt: float, radius_doubt: Array | float) -> None:
        """Go to a stamp [ns] and correct by the wheels; `dt`: since the last step [s]."""
        bank, step, yaw_rate = self._bank, self._step, self._step.yaw_rate
        prediction, correction = self._prediction, self._correction
        correction.take(step)
        if not self.started:
            self._start()
        else:
            prediction.mix(bank, dt, self._speed, step.reading is not None, correction.odds, correction.told)
            prediction.predict(bank, step, dt, self._speed, float(self.mean[U]), correction.beyond_brakes)
            prediction.turn(bank, dt, self._speed, yaw_rate, self._yaw_rate)
        step.begin(stamp)
        if self.started:
            if correction.rim_speeds is not None:
                correction.correct(bank, step, dt, self.mean, self.covariance, radius_doubt)
            if yaw_rate is not None and self._yaw_rate is None:
                bank.correct_one(self._of_yaw, yaw_rate - bank.x[:, U], self._noise.gyroscope**2)
            self._yaw_rate = yaw_rate
            self._tell()

    def _start(self) -> None:
        """Begin at the wheels, of which nothing is known yet, once there have been some steps."""
        rim_speeds = self._correction.rim_speeds
        if rim_speeds is None or not np.isfinite(rim_speeds).any():
            return
        speed = float(np.nanmedian(rim_speeds))
        reading = self._step.reading
        if reading is not None and abs(reading) < TELLING:  # rolls: its tyres begin on their curves
            p, c = self._noise, slice(C, self._e)
            self._bank.p[:, c, c] *= (p.compliance_unlike * p.compliance / p.compliance_stddev) ** 2
        most = 2.0 * self._noise.lateral / max(abs(speed), SLOWEST_TURN)
        self._bank.x[:, U] = np.clip(self._correction.equation.turn(rim_speeds), -most, most)
        variance = (0.5 * speed) ** 2
        if abs(speed) <= STANDING:
            variance = self._correction.standing_variance(self._step, self._speed, float(self.covariance[V, V]))
        self._begin_at(speed, variance)

    def _begin_at(self, speed: float, variance: float) -> None:
        self._bank.x[:, V], self._bank.p[:, V, V] = speed, variance
        self.started = True
        self._tell()

    def _tell(self) -> None:
        """Take the hypotheses together, and keep what is told until the next step."""
        self._bank.hold(MISTOLD, self._correction.odds.wrong)
        self._bank.collapse()
        self.mean, self.covariance, self.another_tyre = self._radius_odds.tell(self._bank.mean, self._bank.covariance)
        """Mean and covariance of the states, shapes (6 + 2 wheels,) and twice that; and per wheel a probability."""
        p, mean, covariance = self._noise, self.mean, self.covariance
        v = float(mean[V])
        self._speed, self._bias, self._kept = (
            v,
            float(mean[B]) if self._step.reading is not None else 0.0,
            1.0 - float(mean[K]),
        )
        self._lasting = (p.radius * v) ** 2
        self.variance = float(covariance[V, V]) + self._lasting if self.started else nan
        """Variance of the speed [m^2/s^2], with the radii."""
        ground, by_yaw = self._correction.equation.ground(mean[V : V + 1], mean[U])
        of_ground = covariance[V, V] + by_yaw**2 * covariance[U, U] + 2.0 * by_yaw * covariance[V, U] + self._lasting
        both = covariance[V, self._e :] + by_yaw * covariance[U, self._e :]
        columns = (
            ground,
            np.maximum(of_ground, 1e-8),
            self._radii * (1.0 + mean[self._e :]),
            np.diagonal(covariance)[self._e :],
            both,
            self._correction.failed,
        )
        self._wheels = [WheelMotion(*each) for each in zip(*[column.tolist() for column in columns], strict=True)]
        if self.started:
            self._carried = self._forward()
