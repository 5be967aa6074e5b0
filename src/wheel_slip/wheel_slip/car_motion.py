"""Estimates speed, yaw rate and slips of a car, by one Kalman filter for each hypothesis about the slope of the road.

| state | | unit | model |
|---|---|---|---|
| v | speed of the middle of the rear axle, forward positive | m/s | v' = (a_m - b)(1 - k) + (t_0 + t) a_m' + n_a |
| b | offset of the accelerometer and slope of the road | m/s^2 | walks: with `offset_walk`, or as the slope does |
| k | error of the accelerometer's gain: scale, pitch of the body | - | constant |
| u | yaw rate, counter-clockwise positive | rad/s | u' = -u / T_u + n_u |
| t | age of the accelerometer beyond that of the vehicle file | s | constant |
| f | error of the force of the engine over the mass: bias of the accelerometer, drag | m/s^2 | constant |
| c_i | slip of tyre i over its force, a share of its load times g | s^2/m | constant while the force is |
| e_i | error of the radius of wheel i, as a share | - | constant: with `radius_walk` |

A wheel at (x_i, y_i) from the middle of the rear axle rolls on ground that passes at g_i = v - u y_i + (u x_i)^2 / 2v:

    z_i + (sigma_i / v)(v' - r omega_i') = g_i (1 - c_i d_i)(1 - e_i) + n_i

in which the left side is the rim speed, ahead of the tyre by the relaxation length sigma_i, and d_i is g times the
force of the tyre over its load: of brake torque and wheel acceleration where the pressures are known, of the reading of
the accelerometer where not, and none on an axle that only rolls. One equation thus serves a wheel that rolls, slides,
is released or locked. A slip is constant at a constant force and vanishes with it, so a change that stays is a slope,
and the moments of little force of a wheel whose brake cycles tell the speed. An age of the accelerometer looks like slip
that grows with the force, so t is not estimated: what it may do to the other states is in their covariance (Schmidt).
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, hypot, isfinite, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_parameters.parameter import constant
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import FRONT, STATED, Vehicle, absolute_deviation, deviation_of, specified_stddev
from vehicle_models.wheel_forces import LEAST_SHARE, drag

Array = NDArray[np.float64]

V, B, K, U, T, F, C = range(7)
"""Indices of the states; those of c begin at C, those of e follow."""
SLOPE_KEPT, SLOPE_CHANGED = range(2)
"""The hypotheses: the road has the slope that was last seen, or has changed it since."""


@dataclass(frozen=True)
class MotionNoise:
    """What the filter does not know, each as a deviation of one standard deviation."""

    acceleration: float = constant(0.1, "noise of a sample of the accelerometer", unit="m/s^2")
    offset: float = constant(0.4, "offset of the accelerometer and slope of the road at the start", unit="m/s^2")
    offset_walk: float = constant(1e-3, "change of the offset in the square root of a second", unit="m/s^2")
    gain: float = constant(0.02, "gain of the accelerometer, where the vehicle file states none, as a share")
    slope: float = constant(0.4, "change of the road's slope times g", unit="m/s^2")
    slope_length: float = constant(40.0, "way on which a slope changes", unit="m")
    slope_every: float = constant(200.0, "way from one change of slope to the next", unit="m")
    slope_known: float = constant(0.05, "deviation of a slope that is known again", unit="m/s^2")
    lateral: float = constant(1.0, "lateral acceleration of ordinary driving", unit="m/s^2")
    curve_time: float = constant(1.0, "time in which a curve comes and goes", unit="s")
    gyroscope: float = constant(0.045, "noise and offset of a sample of the yaw rate", unit="rad/s")
    compliance: float = constant(0.004, "slip over force to expect", unit="s^2/m")
    compliance_stddev: float = constant(0.05, "its deviation", unit="s^2/m")
    compliance_alike: float = constant(0.8, "correlation of it between the tyres")
    steepest: float = constant(1.5, "change of a wheel against the car that is no dive", unit="m/s^2")
    dive_time: float = constant(0.1, "time in which the slip of a diving wheel multiplies", unit="s")
    force: float = constant(0.05, "force that torques tell, over the load, times g", unit="m/s^2")
    blind_force: float = constant(0.6, "force that only the accelerometer tells, over the load, times g", unit="m/s^2")
    pull: float = constant(0.2, "force of all tyres over the mass: bias of the accelerometer, drag", unit="m/s^2")
    engine: float = constant(1.0, "force of the engine over the mass, driving or braking", unit="m/s^2")
    engine_time: float = constant(10.0, "time for which that force may stay", unit="s")
    brakes: float = constant(0.06, "share by which all brakes together differ from their torques: friction of the pads")
    unequal: float = constant(30.0, "share by which the force of one wheel differs from that of the car")
    correlation: float = constant(0.1, "time for which the error of a force is one", unit="s")
    pressure_delay: float = constant(0.012, "age of a pressure", unit="s")
    pressure_lag: float = constant(0.02, "time after which a pressure has come", unit="s")
    radius: float = constant(0.002, "what a wheel's speed is off by over its radius: bumps, as a share")
    radius_walk: float = constant(1e-4, "change of a radius in the square root of a second, as a share")
    bent: float = constant(0.4, "share by which a slip is not its force times c: the curve of a tyre bends")
    unknown_acceleration: float = constant(5.0, "acceleration in the square root of a second, unseen", unit="m/s^2")


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


class _Past(NamedTuple):
    """What was measured at one stamp."""

    stamp: int
    rim_speeds: Array
    integral: float
    """Of the accelerometer's reading since the start [m/s]."""


_JITTER: Final = 100_000
"""By which stamps may be off their grid [ns]."""
_LOCKED: Final = 0.6
"""Rim speed [m/s] below which an encoder reads zero."""
_HARDEST: Final = 12.0
"""Hardest braking of any car on a road [m/s^2]."""
_SLOWEST: Final = 1.0
"""Speed [m/s] that divides in place of a slower one."""
_SLOWEST_TURN: Final = 3.0
"""The same where a curve is told by it: below, a car can turn on the spot."""
_TELLING: Final = 0.5
"""Force over load times g [m/s^2] from which on a tyre's slip has the sign of its force."""


class CarMotion:
    """Motion of one car; nothing is known before `started`."""

    def __init__(self, vehicle: Vehicle, wheel_speed_stddev: float, noise: MotionNoise = MotionNoise()) -> None:
        """Start without samples; `wheel_speed_stddev` is the noise of a wheel speed [rad/s]."""
        self._noise = noise
        wheels, mounting = vehicle.wheels, vehicle.accelerometer
        self._count = len(wheels)
        self._e = C + self._count
        self._size = self._e + self._count
        self._radii = np.array(vehicle.radii)
        self.know_noise(wheel_speed_stddev**2)
        scale = specified_stddev(mounting.deviations, "scale")
        pitch = GRAVITY * deviation_of(mounting.deviations, "pitch_gain", 0.0)
        self._gain = noise.gain if scale is None else hypot(scale / mounting.scale, pitch)
        self._offset = max(noise.offset, deviation_of(mounting.deviations, "bias", 0.0))
        self._delay = mounting.delay
        self._delay_variance = absolute_deviation(mounting.deviations, "delay") ** 2
        self._load = vehicle.mass * GRAVITY * np.array(vehicle.load_shares)
        self._transfer = vehicle.mass * np.array(vehicle.transfer_shares)
        self._mass = vehicle.mass
        self._inertia = np.array([wheel.inertia for wheel in wheels])
        self._relaxation = np.array([wheel.relaxation_length for wheel in wheels])
        driven = np.array([wheel.driven for wheel in wheels], dtype=np.float64)
        self._driven = driven if driven.any() else np.ones(self._count)
        self._vehicle = vehicle
        self._left = np.array([0.5 * vehicle.track * (1.0 if wheel.side == "left" else -1.0) for wheel in wheels])
        self._ahead = np.array([0.5 * vehicle.wheelbase**2 if wheel.axle == FRONT else 0.0 for wheel in wheels])
        common = max(deviation_of(wheel.deviations, "radius", 0.0) / wheel.radius for wheel in wheels)
        unstated = 0.5 * STATED["radius"]  # half is what all have in common
        apart = [deviation_of(each.deviations, "radius", unstated * each.radius) / each.radius for each in wheels]
        self._radius_errors = common**2 + np.diag(np.square(apart))
        alike = noise.compliance_alike
        self._of_speed, self._of_yaw = np.zeros((2, 2, self._size))
        self._of_speed[:, V], self._of_yaw[:, U] = 1.0, 1.0
        self._compliance = noise.compliance_stddev**2 * (alike + (1.0 - alike) * np.eye(self._count))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        p = self._noise
        prior = np.zeros((self._size, self._size))
        prior[B, B], prior[K, K], prior[U, U] = self._offset**2, self._gain**2, 0.1**2
        prior[T, T], prior[F, F] = self._delay_variance, p.pull**2
        prior[C : self._e, C : self._e] = self._compliance
        prior[self._e :, self._e :] = self._radius_errors
        self._x = np.zeros((2, self._size))
        self._x[:, C : self._e] = p.compliance
        self._p = np.repeat(prior[None], 2, axis=0)
        self.probabilities = np.array([0.9, 0.1])
        """Of the hypotheses, shape (2,)."""
        self.started = False
        """Whether there is a speed."""
        self.force = np.zeros(self._count)
        """Force of every tyre over its load, times g [m/s^2], braking positive, shape (wheels,)."""
        self._by_engine = np.zeros(self._count)
        self._past: deque[_Past] = deque(maxlen=400)
        self._integral = 0.0
        self._reading: float | None = None
        self._felt = 0.0
        self._last: int | None = None
        self._told = False
        self._unrest = np.zeros(self._count)
        self._force_before: Array | None = None
        self._collapse()

    def know_noise(self, variance: float) -> None:
        """Take the variance of a wheel speed [rad^2/s^2]."""
        self._rim_variance = variance * float(self._radii.max()) ** 2

    @property
    def speed(self) -> float:
        """Speed of the middle of the rear axle [m/s]."""
        return float(self.mean[V])

    @property
    def yaw_rate(self) -> float:
        """Yaw rate [rad/s], counter-clockwise positive."""
        return float(self.mean[U])

    @property
    def yaw_variance(self) -> float:
        """Variance of it [rad^2/s^2]."""
        return float(self.covariance[U, U])

    @property
    def offset(self) -> float:
        """Offset of the accelerometer, slope of the road included [m/s^2]."""
        return float(self.mean[B])

    @property
    def offset_variance(self) -> float:
        """Variance of it [m^2/s^4]."""
        return float(self.covariance[B, B])

    @property
    def acceleration(self) -> float:
        """Acceleration along the road [m/s^2]."""
        if self._reading is None:
            return self._felt
        return float((self._reading - self.mean[B]) * (1.0 - self.mean[K]))

    @property
    def acceleration_variance(self) -> float:
        """Variance of it [m^2/s^4]."""
        by_gain = float(self.covariance[K, K]) * self.acceleration**2
        if self._reading is None:
            return self._noise.unknown_acceleration**2
        return float(self.covariance[B, B]) + self._noise.acceleration**2 + by_gain

    @property
    def variance(self) -> float:
        """Variance of the speed [m^2/s^2], with the radii and the bend of the tyres' curves."""
        p, v = self._noise, self.mean[V]
        least = max(float(np.min(self.mean[C : self._e] * self.force)), 0.0)
        return float(self.covariance[V, V] + (p.radius * v) ** 2 + (p.bent * least * v) ** 2)

    @property
    def is_forceless(self) -> bool:
        """Whether no tyre has a force to speak of."""
        return abs(self._reading or 0.0) < _TELLING and bool(np.all(np.abs(self.force) < _TELLING))

    @property
    def radius_errors(self) -> tuple[Array, Array]:
        """Errors of the radii as shares, and their standard deviations, shape (wheels,)."""
        return self.mean[self._e :], np.sqrt(np.diagonal(self.covariance)[self._e :])

    def wheel(self, index: int) -> WheelMotion:
        """What a wheel's slip is made of."""
        grounds, by_yaws = self._ground(self.mean[V], self.mean[U])
        ground, by_yaw, e = float(grounds[index]), by_yaws[index], self._e + index
        p = self.covariance
        beside = self.variance - p[V, V]
        variance = p[V, V] + by_yaw**2 * p[U, U] + 2.0 * by_yaw * p[V, U] + beside
        both = float(p[V, e] + by_yaw * p[U, e])
        radius = float(self._radii[index] * (1.0 + self.mean[e]))
        return WheelMotion(ground, max(float(variance), 1e-8), radius, float(p[e, e]), both)

    def _ground(self, speed: Array, yaw_rate: Array) -> tuple[Array, Array]:
        """Return the ground speed of every wheel [m/s] and its change with the yaw rate [m], in the last axis."""
        bend = self._ahead * yaw_rate / np.maximum(np.abs(speed), _SLOWEST_TURN)
        return speed + (bend - self._left) * yaw_rate, 2.0 * bend - self._left

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        reading: float | None,
        torques: Sequence[float] = (),
        yaw_rate: float | None = None,
    ) -> None:
        """Take one sample.

        Args:
            stamp: of the sample [ns], later than the last.
            rim_speeds: r omega of each wheel as measured [m/s], NaN where missing.
            reading: of the accelerometer, forward positive [m/s^2], None if there is none.
            torques: of the brakes [N m], NaN where unknown; empty where no brake is known.
            yaw_rate: [rad/s], counter-clockwise positive, None if there is none.
        """
        if self._last is not None and stamp - self._last > NANOSECONDS:
            self.reset()
        dt = 0.0 if self._last is None else (stamp - self._last) / NANOSECONDS
        self._last = stamp
        rims = np.array(rim_speeds)
        if not self.started:
            self._start(stamp, rims, reading)
            return
        self._mix(dt)
        self._predict(dt, reading)
        self._integral += dt * self._felt
        self._past.append(_Past(stamp, rims, self._integral))
        self._correct_by_wheels(stamp, dt, torques)
        if yaw_rate is not None:
            self._correct_one(self._of_yaw, yaw_rate - self._x[:, U], self._noise.gyroscope**2)
        self._collapse()

    def compare(self, stamp: int, speed: float) -> tuple[float, float] | None:
        """Return by how much a measured speed [m/s] differs from that at a stamp [ns], and the variance of that.

        None where nothing is known of that time. Up to the wheels' own error of some share, it is that of both.
        """
        seen = self._seen_at(stamp)
        if seen is None:
            return None
        then, h = seen
        share = self.probabilities
        innovation = float(share @ (speed - then))
        spread = share @ np.einsum("ma,mab,mb->m", h, self._p, h)
        apart = float(share[0] * share[1] * (then[1] - then[0]) ** 2)
        return innovation, float(spread) + apart + self.variance - float(self.covariance[V, V])

    def set_age_variance(self, variance: float) -> None:
        """Take how far the accelerometer may be late beyond the vehicle file, as a variance [s^2]."""
        self._p[:, T, T] = np.maximum(self._p[:, T, T], variance)

    def take_speed(self, stamp: int, speed: float, variance: float) -> None:
        """Correct by a speed [m/s] with its variance [m^2/s^2] that was measured at a stamp [ns]; or start at it."""
        if not self.started:
            self._begin_at(speed, variance)
            return
        seen = self._seen_at(stamp)
        if seen is not None:
            then, h = seen
            self._correct_one(h, speed - then, variance)
            self._collapse()

    def _seen_at(self, stamp: int) -> tuple[Array, Array] | None:
        """Return the speed at a stamp [ns] by each hypothesis [m/s], and its derivatives by the states."""
        then = next((each for each in reversed(self._past) if each.stamp <= stamp), None)
        if then is None or self._last is None:
            return None
        age = max((self._last - stamp) / NANOSECONDS, 0.0)
        return self._back(age, self._integral - then.integral)

    def _back(self, age: float, integral: float) -> tuple[Array, Array]:
        """Return the speed some time [s] ago, and its derivatives; `integral`: of the readings since [m/s]."""
        x = self._x
        since = integral - age * x[:, B]
        h = np.zeros((2, self._size))
        h[:, V], h[:, B], h[:, K] = 1.0, age * (1.0 - x[:, K]), since
        return x[:, V] - since * (1.0 - x[:, K]), h

    def _start(self, stamp: int, rims: Array, reading: float | None) -> None:
        """Begin at the wheels, with the slip that they may have, once there is a wheel and an accelerometer."""
        p = self._noise
        self._reading = reading
        self._past.append(_Past(stamp, rims, 0.0))
        known = rims[np.isfinite(rims)]
        if not known.size or stamp - self._past[0].stamp < 2.0 * p.pressure_lag * NANOSECONDS:
            return
        speed = float(np.median(known))
        self._past.clear()
        self._past.append(_Past(stamp, rims, 0.0))
        locked = abs(speed) <= _LOCKED
        self._begin_at(speed, self._of_standing(reading or 0.0, 0.0) if locked else (0.5 * speed) ** 2)

    def _begin_at(self, speed: float, variance: float) -> None:
        self._x[:, V], self._p[:, V, V] = speed, variance
        self.started = True
        self._collapse()

    def _of_standing(self, reading: float, speed: float) -> float:
        """Return the variance of a speed of zero by wheels that stand [m^2/s^2]: small, unless they are locked."""
        surprise = (reading / self._offset) ** 2 + speed**2 / (float(self.covariance[V, V]) + _LOCKED**2)
        return float((0.2 * _LOCKED) ** 2 * exp(min(0.5 * surprise, 100.0)))

    def _mix(self, dt: float) -> None:
        """Let the hypotheses change into each other (interacting multiple models)."""
        p, way = self._noise, dt * abs(float(self.mean[V]))
        known = p.slope_known**2 / (p.slope_known**2 + float(self._p[SLOPE_CHANGED, B, B]))
        out, back = min(way / p.slope_every, 0.5), min(way / p.slope_length * known, 0.5)
        joint = np.array([[1.0 - out, out], [back, 1.0 - back]]) * self.probabilities[:, None]
        self.probabilities = joint.sum(axis=0)
        share = joint / np.maximum(self.probabilities, 1e-300)
        apart = self._x[1] - self._x[0]
        spread = np.outer(apart, apart)
        self._x = share.T @ self._x
        first, second = self._p
        self._p = np.stack([s[0] * first + s[1] * second + s[0] * s[1] * spread for s in share.T])

    def _predict(self, dt: float, reading: float | None) -> None:
        p, x = self._noise, self._x
        step = 0.0 if reading is None or self._reading is None else reading - self._reading
        self._reading = reading
        if reading is not None:
            self._felt = reading
        force = self._felt - (x[:, B] if reading is not None else 0.0)
        turn = exp(-dt / p.curve_time)
        f = np.repeat(np.eye(self._size)[None], 2, axis=0)
        if reading is not None:
            f[:, V, B], f[:, V, K], f[:, V, T] = -dt * (1.0 - x[:, K]), -dt * force, step
        f[:, U, U] = turn
        x[:, V] += dt * force * (1.0 - x[:, K]) + (self._delay + x[:, T]) * step
        x[:, U] *= turn
        covariance = f @ self._p @ f.transpose(0, 2, 1)
        speed = max(abs(float(self.mean[V])), _SLOWEST)
        covariance[:, V, V] += (dt * p.acceleration) ** 2 + (dt * p.unknown_acceleration**2 if reading is None else 0.0)
        covariance[SLOPE_KEPT, B, B] += dt * p.offset_walk**2
        unknown = max(2.0 * p.slope**2 - float(covariance[SLOPE_CHANGED, B, B]), 0.0)
        covariance[SLOPE_CHANGED, B, B] += dt * speed / p.slope_length * unknown
        covariance[:, U, U] += (p.lateral / max(speed, _SLOWEST_TURN)) ** 2 * (1.0 - turn**2)
        self._p = covariance

    def _forces(self, reading: float, rim_rates: Array, torques: Sequence[float]) -> tuple[Array, Array]:
        """Return the forces over load times g [m/s^2], and what their error grows to with them [m/s^2].

        What the accelerometer feels beside drag and brakes is the engine's: a force of the driven wheels.
        """
        p, sign = self._noise, 1.0 if self.mean[V] >= 0.0 else -1.0
        load = np.maximum(self._load - self._transfer * sign * reading, LEAST_SHARE * self._load)
        pull = -sign * reading - float(drag(self._vehicle, abs(float(self.mean[V])))) / self._mass
        unrest = np.sqrt(self._unrest)
        self._told = len(torques) == self._count and all(isfinite(torque) for torque in torques)
        if self._told:
            at_rim = (np.array(torques) + self._inertia * sign * rim_rates / self._radii) / self._radii
            force = at_rim / load * GRAVITY
            braked = float(at_rim.sum()) / self._mass
            engine, unsure = pull - braked, p.brakes * braked
        else:
            force = np.full(self._count, max(pull - p.blind_force, 0.0))
            engine, unsure = min(pull, 0.0), 0.0
        share = p.engine**2 / (p.engine**2 + unsure**2)
        driven = self._driven * self._mass * GRAVITY / float((self._driven * load).sum())
        self._by_engine = share * driven if self._told or engine < 0.0 else np.zeros(self._count)
        force = force + self._by_engine * (engine + self.mean[F])
        least, uneven = (p.force, 1.0) if self._told else (p.blind_force, p.unequal)
        doubt = least + uneven * np.minimum(np.abs(force), unrest)
        return force, np.hypot(doubt, sqrt(share) * unsure * driven)

    def _correct_by_wheels(self, stamp: int, dt: float, torques: Sequence[float]) -> None:
        """Take the wheels at the stamp of the pressures that have come by now."""
        p, past = self._noise, self._past
        lag = round(p.pressure_lag * NANOSECONDS) - _JITTER
        samples = next((n for n, each in enumerate(reversed(past)) if stamp - each.stamp >= lag), len(past))
        if 2 * samples + 1 > len(past):
            return
        then, before = past[-1 - samples], past[-1 - 2 * samples]
        span, age = (stamp - before.stamp) / NANOSECONDS, (stamp - then.stamp) / NANOSECONDS
        if not 0.0 < span <= 0.5:
            return
        rates = np.nan_to_num((past[-1].rim_speeds - before.rim_speeds) / span)
        reading = (self._integral - before.integral) / span
        force, doubt = self._forces(reading, rates, torques)
        if self._reading is None:
            self._felt = self._unread(rates, force)
        speed = max(abs(float(self.mean[V])), _SLOWEST)
        behind = self._relaxation / speed
        unlike = reading - self.mean[B] - rates
        z = then.rim_speeds + behind * unlike
        once = self._rim_variance * (1.0 + 2.0 * (behind / span) ** 2)
        late = self._let_slip(dt, force, unlike, behind, span)
        compliance = np.maximum(self.mean[C : self._e], p.compliance)
        noise = (compliance * doubt * speed) ** 2 + late + (p.radius * speed) ** 2
        # To second order: while neither slip over force nor the engine's force is known, their product is an error.
        unknown = np.diagonal(self.covariance)
        both = unknown[C : self._e] * unknown[F] * (self._by_engine * speed) ** 2
        noise = noise + both * p.engine_time / p.correlation
        use = np.isfinite(z) & (np.abs(z) > _LOCKED)
        if not use.any() and np.isfinite(z).any():
            standing = self._of_standing(reading, float(self.mean[V]))
            self._correct_one(self._of_speed, -self._x[:, V], standing)
        many = max(p.correlation / dt, 1.0)
        self._apply(np.where(use, z, 0.0), use, once, noise, many, age, self._integral - then.integral)
        self._keep_signs(np.sqrt(late))

    def _unread(self, rim_rates: Array, force: Array) -> float:
        """Return the acceleration without an accelerometer [m/s^2]: of the forces where told, else of the wheels."""
        if self._told and np.any(force > _TELLING):
            load = np.maximum(self._load - self._transfer * self._felt, LEAST_SHARE * self._load)
            resistance = float(drag(self._vehicle, abs(float(self.mean[V]))))
            return -(float(force @ load) / GRAVITY + resistance) / self._mass
        return float(np.clip(np.median(rim_rates), -_HARDEST, _HARDEST))

    def _let_slip(self, dt: float, force: Array, unlike: Array, behind: Array, span: float) -> Array:
        """Let c change where forces do; return the variance of a rim that tyre and pressure follow late [m^2/s^2]."""
        p, speed = self._noise, max(abs(float(self.mean[V])), _SLOWEST)
        rest = np.maximum(np.abs(unlike) - 3.0 * sqrt(2.0 * self._rim_variance) / span, 0.0)
        sudden = np.maximum(rest - (p.steepest if self._told else 0.0), 0.0)
        weight = np.maximum(np.abs(force), _TELLING)
        change = np.zeros(self._count) if self._force_before is None else force - self._force_before
        change = change * min(dt / p.pressure_lag, 1.0)
        self._force_before = force - change if self._force_before is None else self._force_before + change
        self.force = force
        grown = (sudden / (speed * weight)) ** 2 * p.dive_time * dt
        compliance = np.maximum(self.mean[C : self._e], p.compliance)
        grown += (compliance * change / weight) ** 2 * max(p.correlation / dt, 1.0)
        wheels = np.arange(C, self._e)
        self._p[:, wheels, wheels] += grown
        self._p[:, self._e + wheels - C, self._e + wheels - C] += dt * p.radius_walk**2
        share = dt / (p.correlation + dt)
        self._unrest = np.maximum(rest**2, self._unrest + share * (rest**2 - self._unrest))
        return ((0.5 if self._told else 1.0) * behind + p.pressure_delay) ** 2 * self._unrest

    def _apply(self, z: Array, use: Array, once: Array, noise: Array, many: float, age: float, integral: float) -> None:
        """Correct both filters by all wheels at once.

        Args:
            z: rim speeds [m/s], shape (wheels,).
            use: which of them count.
            once: variance of what is drawn anew each sample [m^2/s^2].
            noise: variance of what lasts for `many` samples [m^2/s^2].
            many: see `noise`.
            age: of z [s].
            integral: of the accelerometer since [m/s].
        """
        x, covariance = self._x, self._p
        then = x[:, V] - (integral - age * x[:, B]) * (1.0 - x[:, K])
        of_radius = 1.0 - x[:, self._e :]
        roll = (1.0 - x[:, C : self._e] * self.force) * of_radius
        ground, by_yaw = self._ground(then[:, None], x[:, U, None])
        h = np.zeros((2, self._count, self._size))
        h[:, :, V], h[:, :, B] = roll, age * roll
        h[:, :, U] = roll * by_yaw
        wheels = np.arange(self._count)
        h[:, :, F] = -ground * x[:, C : self._e] * self._by_engine * of_radius
        h[:, wheels, C + wheels] = -ground * self.force * of_radius
        h[:, wheels, self._e + wheels] = -ground * roll
        h *= use[None, :, None]
        innovation = np.where(use, z - ground * roll, 0.0)
        ph = covariance @ h.transpose(0, 2, 1)
        inner = h @ ph
        every = np.where(use, once + noise * many, 1.0)
        inverse = np.linalg.inv(inner + np.diag(every))
        gain = ph @ inverse
        gain[:, T] = 0.0
        # An error that lasts is one, not many: a sample has its share of it.
        fresh = np.where(use, once + noise, 1.0)
        independent = np.where(use, (once + noise) / every, 0.0)
        own = np.diagonal(inner, axis1=1, axis2=2) + fresh
        whitened = innovation**2 / own + np.log(own)
        self._x = x + np.einsum("mai,mi->ma", gain, innovation)
        lower = covariance - gain @ ph.transpose(0, 2, 1)
        lower[:, T] = lower[:, :, T]
        self._p = 0.5 * (lower + lower.transpose(0, 2, 1))
        self._weigh(-0.5 * (whitened @ independent))

    def _keep_signs(self, late: Array) -> None:
        """Move a slip that is against its force to zero, with what goes with it; what is known stays as it is."""
        x, covariance = self._x, self._p
        reach = np.abs(x[:, V, None]) * np.abs(self.force)
        for m, i in np.argwhere((np.abs(self.force) > _TELLING) & (x[:, C : self._e] * reach < -late)):
            least = -late[i] / max(reach[m, i], 1e-6)
            if x[m, C + i] < least:  # the move of a wheel before it has moved this one too
                x[m] -= covariance[m, :, C + i] / covariance[m, C + i, C + i] * (x[m, C + i] - least)

    def _correct_one(self, h: Array, innovation: Array, variance: float) -> None:
        """Correct by one measurement.

        Args:
            h: its derivatives by the states, shape (2, states).
            innovation: what it differs by from what is expected, shape (2,).
            variance: of the measurement.
        """
        ph = np.einsum("mab,mb->ma", self._p, h)
        spread = np.einsum("ma,ma->m", h, ph) + variance
        gain = ph / spread[:, None]
        gain[:, T] = 0.0
        self._x = self._x + gain * innovation[:, None]
        self._p = self._p - gain[:, :, None] * ph[:, None, :]
        self._p[:, T] = self._p[:, :, T]
        self._weigh(-0.5 * (innovation**2 / spread + np.log(spread)))

    def _weigh(self, log_likelihoods: Array) -> None:
        weights = self.probabilities * np.exp(log_likelihoods - log_likelihoods.max())
        self.probabilities = np.maximum(weights / weights.sum(), 1e-12)

    def _collapse(self) -> None:
        """Take both hypotheses together."""
        first, second = self.probabilities
        self.mean = first * self._x[0] + second * self._x[1]
        """Mean of the states, shape (6 + 2 wheels,)."""
        apart = self._x[1] - self._x[0]
        self.covariance = first * self._p[0] + second * self._p[1] + first * second * np.outer(apart, apart)
        """Of them, shape (6 + 2 wheels, 6 + 2 wheels)."""
