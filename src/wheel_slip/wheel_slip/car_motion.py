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

The wheels correct once in a `step`, by their means over the second step before the last: their rates are known on both
sides of it, and the pressures that belong to these have come by then. Within a step the accelerometer carries the
speed.
"""

from collections import deque
from collections.abc import Sequence
from math import exp, hypot, isfinite, nan, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING
from vehicle_models.vehicle import STATED, Vehicle, absolute_deviation, deviation_of, specified_stddev
from wheel_slip.filter_bank import FilterBank
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.radius_odds import RadiusOdds
from wheel_slip.step import Means, Step
from wheel_slip.torque_odds import TorqueOdds
from wheel_slip.tyre_forces import BLIND, LOCKED, SLOWEST, TELLING, TOLD, TyreForces
from wheel_slip.tyre_slip import TyreSlip
from wheel_slip.wheel_equation import SLOWEST_TURN, B, C, F, K, S, T, U, V, WheelEquation

Array = NDArray[np.float64]

SLOPE_KEPT, SLOPE_CHANGED, MISREAD, MISTOLD = range(4)
"""The hypotheses: the road has the slope that was last seen, or has changed it since; or the accelerometer is late,
turned or stuck, and its offset changes as the accelerations of cars do; or the torques are not those of the brakes."""
_PRIOR: Final = np.array([0.898, 0.1, 0.001, 0.001])
"""Their probabilities at the start."""
_ROW: Final = np.array([TOLD, TOLD, TOLD, BLIND])
"""By which forces each of them goes."""
_JITTER: Final = 100_000
"""By which stamps may be off their grid [ns]."""
_STANDS: Final = 1.0
"""Time in which wheels that stand say once that the car does [s]."""


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


class CarMotion:
    """Motion of one car; nothing is known before `started`."""

    def __init__(self, vehicle: Vehicle, wheel_speed_stddev: float, noise: MotionNoise = MotionNoise()) -> None:
        """Start without samples; `wheel_speed_stddev` is the noise of a wheel speed [rad/s]."""
        self._noise = noise
        wheels, mounting = vehicle.wheels, vehicle.accelerometer
        self._count = len(wheels)
        self._e = C + self._count
        self._radii = np.array(vehicle.radii)
        self.set_noise(wheel_speed_stddev**2)
        self.set_drift(0.0)
        self._step = Step(self._count)
        self._forces, self._tyres = TyreForces(vehicle, noise), TyreSlip(self._count, noise)
        self._odds = TorqueOdds(noise)
        scale = specified_stddev(mounting.deviations, "scale")
        pitch = GRAVITY * deviation_of(mounting.deviations, "pitch_gain", 0.0)
        gain = noise.gain if scale is None else hypot(scale / mounting.scale, pitch)
        self._offset = max(noise.offset, deviation_of(mounting.deviations, "bias", 0.0))
        age = absolute_deviation(mounting.deviations, "delay")
        self._delay = mounting.delay
        self._relaxation = np.array([wheel.relaxation_length for wheel in wheels])
        self._equation = WheelEquation(vehicle)
        stated = [deviation_of(each.deviations, "radius", STATED["radius"] * each.radius) for each in wheels]
        apart = np.array(stated) / self._radii
        prior = np.zeros((C + 2 * self._count,) * 2)
        prior[B, B], prior[K, K], prior[U, U] = self._offset**2, gain**2, (noise.lateral / SLOWEST_TURN) ** 2
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
        self._of_speed, self._of_yaw = np.zeros((2, _PRIOR.size, C + 2 * self._count))
        self._of_speed[:, V], self._of_yaw[:, U] = 1.0, 1.0
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._bank = FilterBank(self._expected, self._prior, _PRIOR, T)
        self.started = False
        """Whether there is a speed."""
        self._tyres.reset()
        self._odds.reset()
        self._failed, self._untold = np.zeros(self._count), np.zeros((2, self._count))
        self._steps: deque[Means] = deque(maxlen=4)
        self._torques: deque[Array] = deque(maxlen=3)
        self._step.reset()
        self._carried = self._misread_way = 0.0
        self._yaw_rate: float | None = None
        self._judged = False
        self._beyond_brakes = (nan, nan)
        """What the accelerometer read beyond the brakes' deceleration in the last two steps [m/s^2]."""
        self._tell()

    def set_noise(self, variance: float) -> None:
        """Take the variance of a wheel speed [rad^2/s^2]."""
        self._rim_variance = variance * float(self._radii.max()) ** 2

    def set_drift(self, variance: float) -> None:
        """Take the variance that the noise of the accelerometer brings to the speed in a second [m^2/s^3]."""
        self._drift = variance

    @property
    def probabilities(self) -> Array:
        """Of the hypotheses, shape (4,)."""
        return self._bank.probabilities

    @property
    def knows_torques(self) -> bool:
        """Whether the torques of all brakes are known."""
        return self._odds.known

    @property
    def speed(self) -> float:
        """Speed of the middle of the rear axle [m/s]."""
        return self._speed + self._carried

    @property
    def travelled(self) -> float:
        """Integral of the acceleration as it was felt [m/s], slope and bias included; begins anywhere."""
        return self._step.way - self._misread_way

    @property
    def _misread(self) -> float:
        """By how much the accelerometer reads another motion than that of the car [m/s^2]."""
        bank = self._bank
        return float(bank.probabilities[MISREAD] * (bank.x[MISREAD, B] - bank.x[SLOPE_KEPT, B]))

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
        """Whether no tyre has a force to speak of."""
        return abs(self._step.reading or 0.0) < TELLING and bool(np.all(np.abs(self._tyres.force) < TELLING))

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
        self._radius_doubt = radius_doubt
        if self._step.pauses(stamp):
            self.reset()
        self._step.add(stamp, rim_speeds, reading, torques, yaw_rate)
        self._carried = self._forward() if self.started else 0.0
        if stamp - self._step.stamp >= self._noise.step * NANOSECONDS - _JITTER:
            self._take_step(stamp, min(self._step.since, 1.0))

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
        return None if gone is None else self._at(x, (self._step.stamp - stamp) / NANOSECONDS, gone)

    def _at(self, x: Array, age: float, way: float) -> tuple[Array, Array]:
        """Return the same some time [s] before the last step; `way`: integral of the readings since then [m/s]."""
        h = np.zeros_like(x)
        since, kept = way - age * x[..., B], 1.0 - x[..., K]
        h[..., V], h[..., B], h[..., K] = 1.0, age * kept, since
        return x[..., V] - since * kept, h

    def _forward(self) -> float:
        """Return the change of the speed since the last step [m/s]."""
        step = self._step
        return (step.gone - self._bias * step.since) * self._kept + self._delay * step.moved

    def _take_step(self, stamp: int, dt: float) -> None:
        """Go to a stamp [ns] and correct by the wheels; `dt`: since the last step [s]."""
        self._steps.append(self._step.means)
        torques, yaw_rate = self._step.torques, self._step.yaw_rate
        if self._forces.told_by(torques):
            self._torques.append(np.array(torques))
        else:
            self._torques.clear()
        told = len(self._torques) == 3 and len(self._steps) == 4
        if told:  # as the rates of two steps weigh what three do: one that alternates moves no wheel for as long
            first, second, third = self._torques
            torques = (0.25 * first + 0.5 * second + 0.25 * third).tolist()
        if not self.started:
            self._start()
        else:
            self._mix(dt, told)
            self._predict(dt)
            self._turn(dt, yaw_rate)
        self._step.begin(stamp)
        if self.started:
            if len(self._steps) >= 3:
                self._correct_by_wheels(stamp, dt, torques if told else None)
            if yaw_rate is not None and self._yaw_rate is None:
                self._bank.correct_one(self._of_yaw, yaw_rate - self._bank.x[:, U], self._noise.gyroscope**2)
            self._yaw_rate = yaw_rate
            self._tell()

    def _start(self) -> None:
        """Begin at the wheels, of which nothing is known yet, once there have been some steps."""
        known = self._steps[-1].rim_speeds[np.isfinite(self._steps[-1].rim_speeds)]
        if known.size and len(self._steps) >= 3:
            speed = float(np.median(known))
            locked = abs(speed) <= LOCKED
            reading = self._step.reading
            if reading is not None and abs(reading) < TELLING:  # rolls: its tyres begin on their curves
                p, c = self._noise, slice(C, self._e)
                self._bank.p[:, c, c] *= (p.compliance_unlike * p.compliance / p.compliance_stddev) ** 2
            most = 2.0 * self._noise.lateral / max(abs(speed), SLOWEST_TURN)
            self._bank.x[:, U] = np.clip(self._equation.turn(self._steps[-1].rim_speeds), -most, most)
            self._begin_at(speed, self._standing_variance() if locked else (0.5 * speed) ** 2)

    def _begin_at(self, speed: float, variance: float) -> None:
        self._bank.x[:, V], self._bank.p[:, V, V] = speed, variance
        self.started = True
        self._tell()

    def _mix(self, dt: float, told: bool) -> None:
        """Let the hypotheses change into each other; `told`: whether torques are known."""
        p, way = self._noise, dt * abs(self._speed)
        known = p.slope_known**2 / (p.slope_known**2 + float(self._bank.p[SLOPE_CHANGED, B, B]))
        out, back = min(way / p.slope_every, 0.5), min(way / p.slope_length * known, 0.5)
        fails, heals = dt / p.fault_every, dt / p.fault_time
        misread, read = (fails, heals) if self._step.reading is not None else (0.0, 1.0)
        # While no brake is on, no torque can be wrong: that hypothesis follows the others, and it ends with the brakes.
        wrong, judges = self._odds.wrong, told and self._odds.judges
        mistold, right, stays = (
            (0.0, 0.0, 1.0) if judges else (wrong, self._judged * (1.0 - wrong), self._judged * wrong)
        )
        self._judged = judges
        misread *= 1.0 - mistold
        sound = 1.0 - misread - mistold
        change = np.array(
            [
                [sound * (1.0 - out), sound * out, misread, mistold],
                [sound * back, sound * (1.0 - back), misread, mistold],
                [0.0, 0.0, 1.0 - read, 0.0],
                [right, 0.0, 0.0, stays],
                # An accelerometer that reads the motion of the car again has any offset, on any slope.
                [0.0, read, 0.0, 0.0],
            ]
        )
        self._bank.mix(change, MISREAD, B, 0.0, self._offset**2)

    def _predict(self, dt: float) -> None:
        """Go on to the end of a step."""
        p, x, covariance = self._noise, self._bank.x, self._bank.p
        seen = self._step.reading is not None
        way, kept = self._step.gone, 1.0 - x[:, K]
        by_offset = way - dt * x[:, B] if seen else np.full(len(x), way)
        x[:, V] += by_offset * kept + self._delay * self._step.moved
        if seen:
            f = np.stack([-dt * kept, -by_offset, np.full(len(x), self._step.moved)], axis=1)
            covariance[:, V] += (f[:, None] @ covariance[:, [B, K, T]])[:, 0]
            covariance[:, :, V] += (covariance[:, :, [B, K, T]] @ f[:, :, None])[:, :, 0]
        speed = max(abs(self._speed), SLOWEST)
        between = dt / max(self._step.samples, 1)
        noise = dt * max(between * p.acceleration**2, self._drift) + dt * between**2 * p.jerk**2 / 3.0
        # A body that drifts in a curve feels a share of the lateral acceleration along its axis.
        across = p.sideslip * float(self.mean[U]) * self._speed
        covariance[:, V, V] += noise + 2.0 * p.curve_time * dt * across**2 if seen else dt * p.unknown_acceleration**2
        covariance[[SLOPE_KEPT, MISTOLD], B, B] += dt * p.offset_walk**2
        unknown = max(2.0 * p.slope**2 - float(covariance[SLOPE_CHANGED, B, B]), 0.0)
        covariance[SLOPE_CHANGED, B, B] += dt * speed / p.slope_length * unknown
        self._misread_walk(dt)
        self._bank.forget(S, exp(-dt / p.slide_time), p.slide, p.slide_alike * p.slide_stddev**2)

    def _turn(self, dt: float, yaw_rate: float | None) -> None:
        """Let the yaw rate follow what is measured, whose error lasts as a curve does, else let the curve end."""
        p, stddev = self._noise, self._noise.lateral / max(abs(self._speed), SLOWEST_TURN)
        towards = 0.0
        if yaw_rate is not None and self._yaw_rate is not None:
            self._bank.x[:, U] += yaw_rate - self._yaw_rate
            towards, stddev = yaw_rate, p.gyroscope
        self._bank.forget(U, exp(-dt / p.curve_time), towards, stddev**2)

    def _misread_walk(self, dt: float) -> None:
        """Let the offset of a wrong accelerometer follow what it reads beyond the brakes, as the torques tell them."""
        p, (before, now) = self._noise, self._beyond_brakes
        told = isfinite(before) and isfinite(now)
        if told:
            self._bank.x[MISREAD, B] += now - before
        self._bank.p[MISREAD, B, B] += dt * (2.0 * p.engine**2 / p.engine_time if told else p.misread**2)

    def _correct_by_wheels(self, stamp: int, dt: float, torques: Sequence[float] | None) -> None:
        """Take the means of the wheels over the second step before the last; `torques`: None unless they are known."""
        p, bank = self._noise, self._bank
        before, then, now = list(self._steps)[-3:] if torques is None else list(self._steps)[:3]
        span, age = (now.stamp - before.stamp) / NANOSECONDS, (stamp - then.stamp) / NANOSECONDS
        if not 0.0 < span <= 0.5:
            return
        unread = self._step.reading is None
        rates = (now.rim_speeds - before.rim_speeds) / span
        rates[~np.isfinite(rates)] = 0.0
        misread, read = self._misread, (now.way - before.way) / span
        self._misread_way += dt * misread
        reading = read - misread
        mean_speed, offset = float(bank.x[0, V]), float(self.mean[B])
        speed = max(abs(mean_speed), SLOWEST)
        behind = self._relaxation / speed
        unlike = reading - (0.0 if unread else offset - misread) - rates
        rest = np.maximum(np.abs(unlike) - 3.0 * sqrt(2.0 * self._rim_variance) / span, 0.0)
        locked = np.abs(then.rim_speeds) <= LOCKED
        settles = np.array([[p.correlation if torques is None else p.pressure_delay], [p.correlation]])
        self._tyres.disturb(dt, rest, behind + settles)
        forces = self._forces.of(
            reading, mean_speed, rates, torques, self._tyres.unrest, float(self.mean[F]), unread, locked
        )
        self._beyond_brakes = (self._beyond_brakes[1], read - forces.felt)
        self._odds.update(dt, forces.pull, nan if unread else forces.braked, float(bank.probabilities[MISREAD]))
        if unread:
            felt = float(np.clip(np.median(rates), -HARDEST_BRAKING, HARDEST_BRAKING))
            share = dt / (p.correlation + dt)
            self._step.felt += share * ((forces.felt if isfinite(forces.felt) else felt) - self._step.felt)
        z = then.rim_speeds + behind * unlike
        once = self._rim_variance / then.samples * (1.0 + 2.0 * (behind / span) ** 2)
        compliance = np.maximum(self.mean[C : self._e], p.compliance)
        change = self._tyres.change(dt, mean_speed, forces, compliance, np.copysign(rest, unlike), locked)
        relaxed = (change.kept[_ROW], change.towards[_ROW], change.by[_ROW], change.variance[_ROW])
        bank.relax(slice(C, self._e), *relaxed, S)
        # An error by the engine's force lasts, and is told once, until the slip that it acts on is another one.
        self._untold += dt / p.engine_time - self._untold * min(dt / p.correlation, 1.0)
        self._untold = np.where(change.kept == 0.0, 1.0, np.minimum(self._untold, 1.0))
        bank.add(slice(self._e, None), dt * p.radius_walk**2)
        late = ((np.where(forces.told, 0.5, 1.0) * behind + p.pressure_delay) * self._tyres.unrest) ** 2
        # To second order: while neither slip over force nor the engine's force is known, their product is an error.
        unknown = np.diagonal(self.covariance)
        both = unknown[C : self._e] * unknown[F] * (forces.by_engine * speed) ** 2
        lasting = (
            (compliance * forces.doubt * speed) ** 2 + late + (p.radius**2 + np.square(self._radius_doubt)) * speed**2
        )
        lasting = lasting + both / np.maximum(self._untold, p.correlation / p.engine_time)
        use = np.isfinite(z) & ~locked
        if use.any():
            way = self._step.way - then.way
            self._apply(
                np.where(use, z, 0.0), use, forces.by_engine, once, lasting, max(p.correlation / dt, 1.0), age, way
            )
            self._keep_signs(np.sqrt(late[_ROW]))
        elif np.isfinite(z).any():
            bank.correct_one(self._of_speed, -bank.x[:, V], self._standing_variance())

    def _standing_variance(self) -> float:
        """Return the variance of a speed of zero by wheels that stand [m^2/s^2]: small, unless they are locked."""
        known = float(self.covariance[V, V]) + LOCKED**2
        surprise = (self._step.felt / self._offset) ** 2 + self._speed**2 / known
        once = (0.2 * LOCKED) ** 2 * exp(min(0.5 * surprise, 20.0))
        return once * _STANDS / self._noise.step  # however long they stand, that they are locked is one doubt

    def _apply(
        self,
        z: Array,
        use: NDArray[np.bool_],
        by_engine: Array,
        once: Array,
        lasting: Array,
        many: float,
        age: float,
        way: float,
    ) -> None:
        """Correct all filters by all wheels at once.

        Args:
            z: rim speeds [m/s], shape (wheels,).
            use: which of them count.
            by_engine: change of the forces with f, shape (2, wheels).
            once: variance of what is drawn anew in each step [m^2/s^2], shape (wheels,).
            lasting: variance of what lasts for `many` steps [m^2/s^2], shape (2, wheels).
            many: see `lasting`.
            age: of z at the last step [s].
            way: integral of the readings since then [m/s].
        """
        bank = self._bank
        then, by_then = self._at(bank.x, age, way)
        expected, h = self._equation.expected(then, by_then, bank.x, self._tyres.force[_ROW], by_engine[_ROW])
        h[:, ~use] = 0.0
        innovation = np.where(use, z - expected, 0.0)
        sound = np.where(use, once + lasting[_ROW] * many, 1.0)
        # One that has failed, or spins beyond any slip, is not explained by any state, and is not believed for a while.
        lasts = self._noise.failed / self._noise.step
        failed = bank.doubt(h, innovation, sound, self._failed, self._noise.surprise, lasts)
        self._failed = failed * exp(-1.0 / lasts)
        before = bank.x
        misfits = bank.correct(h, innovation, sound + failed, self._noise.quiet)
        self._odds.contradict(float(misfits[MISTOLD]) - np.count_nonzero(use))
        self._keep_open(before)

    def _keep_open(self, before: Array) -> None:
        """Keep open what rim speeds do not tell: an error of all radii alike, with speed and yaw rate in proportion."""
        x, p, share = self._bank.x, self._bank.p, 1.0 / self._count
        alike = 1.0 + share * (x - before)[:, self._e :].sum(axis=1)
        for state in (V, U):
            moved = (share * (x[:, state] - before[:, state] * alike))[:, None]
            p[:, state] += moved * p[:, self._e :].sum(axis=1)
            p[:, :, state] += moved * p[:, :, self._e :].sum(axis=2)

    def _keep_signs(self, late: Array) -> None:
        """Move a slip that is against its force to zero, with what goes with it; what is known stays as it is."""
        x, covariance = self._bank.x, self._bank.p
        force = np.abs(self._tyres.force[_ROW])
        reach = np.abs(x[:, V, None]) * force
        against = (force > TELLING) & (x[:, C : self._e] * reach < -late)
        if not against.any():
            return
        for m, i in np.argwhere(against):
            least = -late[m, i] / max(reach[m, i], 1e-6)
            if x[m, C + i] < least:  # the move of a wheel before it has moved this one too
                x[m] -= covariance[m, :, C + i] / covariance[m, C + i, C + i] * (x[m, C + i] - least)

    def _tell(self) -> None:
        """Take the hypotheses together, and keep what is told until the next step."""
        self._bank.hold(MISTOLD, self._odds.wrong)
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
        ground, by_yaw = self._equation.ground(mean[V : V + 1], mean[U])
        of_ground = covariance[V, V] + by_yaw**2 * covariance[U, U] + 2.0 * by_yaw * covariance[V, U] + self._lasting
        both = covariance[V, self._e :] + by_yaw * covariance[U, self._e :]
        columns = (
            ground,
            np.maximum(of_ground, 1e-8),
            self._radii * (1.0 + mean[self._e :]),
            np.diagonal(covariance)[self._e :],
            both,
        )
        self._wheels = [WheelMotion(*each) for each in zip(*[column.tolist() for column in columns], strict=True)]
        if self.started:
            self._carried = self._forward()
