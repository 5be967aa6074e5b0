"""Corrects the motion of a car by the speeds of its wheels, and judges by them the brakes' torques and failed wheels.

The wheels correct once in a step, by their means over the second step before the last: their rates are known on both
sides of it, and the pressures that belong to these have come by then.
"""

from collections import deque
from math import exp, isfinite, nan, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING, STANDING
from vehicle_models.vehicle import Vehicle
from wheel_slip.filter_bank import FilterBank
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.prediction import MISREAD, MISTOLD, PRIOR, ROW, SLOPE_KEPT
from wheel_slip.step import Means, Step
from wheel_slip.torque_odds import TorqueOdds
from wheel_slip.tyre_forces import SLOWEST, TELLING, Forces, TyreForces
from wheel_slip.tyre_slip import TyreSlip
from wheel_slip.wheel_equation import B, C, F, S, U, V, WheelEquation, speed_before

Array = NDArray[np.float64]

_STANDS: Final = 1.0
"""Time in which wheels that stand say once that the car does [s]."""


class WheelCorrection:
    """Of one car."""

    def __init__(self, vehicle: Vehicle, noise: MotionNoise, offset: float) -> None:
        """Take a car whose accelerometer's offset has a deviation of `offset` [m/s^2]."""
        self._noise, self._offset, self._count = noise, offset, len(vehicle.wheels)
        self._e = C + self._count
        self._forces, self._tyres = TyreForces(vehicle, noise), TyreSlip(self._count, noise)
        self._relaxation = np.array([wheel.relaxation_length for wheel in vehicle.wheels])
        self._largest_radius = max(vehicle.radii)
        self._of_speed = np.zeros((PRIOR.size, C + 2 * self._count))
        self._of_speed[:, V] = 1.0
        self.equation = WheelEquation(vehicle)
        self.odds = TorqueOdds(noise)
        """Of the brakes' torques."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._tyres.reset()
        self.odds.reset()
        self.failed, self._untold = np.zeros(self._count), np.zeros((2, self._count))
        """Variances of rim speeds that no motion explains [m^2/s^2], shape (wheels,)."""
        self._steps: deque[Means] = deque(maxlen=4)
        self._torques: deque[Array] = deque(maxlen=3)
        self.misread_way = 0.0
        """Integral of what an accelerometer that is wrong has read beyond the motion of the car [m/s]."""
        self.beyond_brakes = (nan, nan)
        """What the accelerometer read beyond the brakes' deceleration in the last two steps [m/s^2]."""

    def set_noise(self, variance: float) -> None:
        """Take the variance of a wheel speed [rad^2/s^2]."""
        self._rim_variance = variance * self._largest_radius**2

    @property
    def largest_force(self) -> float:
        """Largest force of a tyre over its load, times g [m/s^2]."""
        return float(np.max(np.abs(self._tyres.force)))

    @property
    def rim_speeds(self) -> Array | None:
        """Means of r omega over the last step [m/s], shape (wheels,), NaN where missing; None before the third step."""
        return self._steps[-1].rim_speeds if len(self._steps) >= 3 else None

    @property
    def told(self) -> bool:
        """Whether the torques of all brakes have been known for three steps."""
        return len(self._torques) == 3 and len(self._steps) == 4

    def take(self, step: Step) -> None:
        """Keep the means of a step that ends."""
        self._steps.append(step.means)
        torques = step.torques
        if self._forces.told_by(torques):
            self._torques.append(np.array(torques))
        else:
            self._torques.clear()

    def correct(
        self,
        bank: FilterBank,
        step: Step,
        dt: float,
        mean: Array,
        covariance: Array,
        radius_doubt: Array | float,
    ) -> None:
        """Correct by the means of the wheels, once there are three steps.

        Args:
            bank: the filters, gone on to the end of the last step.
            step: that begins there.
            dt: length of the last step [s].
            mean: of the states after the last correction, shape (states,).
            covariance: of them.
            radius_doubt: standard deviations of the radii under load as shares, shape (wheels,).
        """
        before, then, now = list(self._steps)[:3] if self.told else list(self._steps)[-3:]
        span, age = (now.stamp - before.stamp) / NANOSECONDS, (step.stamp - then.stamp) / NANOSECONDS
        if not 0.0 < span <= 0.5:
            return
        p, unread = self._noise, step.reading is None
        rates = (now.rim_speeds - before.rim_speeds) / span
        rates[~np.isfinite(rates)] = 0.0
        read = (now.way - before.way) / span
        misread = float(bank.probabilities[MISREAD] * (bank.x[MISREAD, B] - bank.x[SLOPE_KEPT, B]))
        self.misread_way += dt * misread
        reading = read - misread
        speed, offset = float(bank.x[0, V]), float(mean[B])
        behind = self._relaxation / max(abs(speed), SLOWEST)
        unlike = reading - (0.0 if unread else offset - misread) - rates
        rest = np.maximum(np.abs(unlike) - 3.0 * sqrt(2.0 * self._rim_variance) / span, 0.0)
        locked = np.abs(then.rim_speeds) <= STANDING
        settles = np.array([[p.pressure_delay if self.told else p.correlation], [p.correlation]])
        self._tyres.disturb(dt, rest, behind + settles)
        torques, unrest, error = self._smoothed(), self._tyres.unrest, float(mean[F])
        forces = self._forces.of(reading, speed, rates, torques, unrest, error, unread, locked)
        self.beyond_brakes = (self.beyond_brakes[1], read - forces.felt)
        # As it was felt: what judges the accelerometer must not be corrected by what is thought of it.
        pull = forces.pull - (misread if speed >= 0.0 else -misread)
        if_told = float(bank.probabilities[MISREAD] / max(1.0 - bank.probabilities[MISTOLD], 1e-9))
        self.odds.update(dt, pull, nan if unread else forces.braked, if_told)
        if unread:
            felt = float(np.clip(np.median(rates), -HARDEST_BRAKING, HARDEST_BRAKING))
            share = dt / (p.correlation + dt)
            step.felt += share * ((forces.felt if isfinite(forces.felt) else felt) - step.felt)
        compliance = np.maximum(mean[C : self._e], p.compliance)
        change = self._tyres.change(dt, speed, forces, compliance, np.copysign(rest, unlike), locked)
        relaxed = (change.kept[ROW], change.towards[ROW], change.by[ROW], change.variance[ROW])
        bank.relax(slice(C, self._e), *relaxed, S)
        # An error by the engine's force lasts, and is told once, until the slip that it acts on is another one.
        self._untold += dt / p.engine_time - self._untold * min(dt / p.correlation, 1.0)
        self._untold = np.where(change.kept == 0.0, 1.0, np.minimum(self._untold, 1.0))
        bank.add(slice(self._e, None), dt * p.radius_walk**2)
        late = ((np.where(forces.told, 0.5, 1.0) * behind + p.pressure_delay) * self._tyres.unrest) ** 2
        z = then.rim_speeds + behind * unlike
        use = np.isfinite(z) & ~locked
        if use.any():
            once = self._rim_variance / then.samples * (1.0 + 2.0 * (behind / span) ** 2)
            lasting = self._lasting(speed, covariance, compliance, forces, radius_doubt, late)
            many, way = max(p.correlation / dt, 1.0), step.way - then.way
            self._apply(bank, np.where(use, z, 0.0), use, forces.by_engine, once, lasting, many, age, way)
            self._keep_signs(bank, np.sqrt(late[ROW]))
        elif np.isfinite(z).any():
            standing = self.standing_variance(step, float(mean[V]), float(covariance[V, V]))
            bank.correct_one(self._of_speed, -bank.x[:, V], standing)

    def standing_variance(self, step: Step, speed: float, variance: float) -> float:
        """Return the variance of a speed of zero by wheels that stand [m^2/s^2]: small, unless they are locked.

        Args:
            step: that is going on.
            speed: of the car, as it was known [m/s].
            variance: of that [m^2/s^2].
        """
        surprise = (step.felt / self._offset) ** 2 + speed**2 / (variance + STANDING**2)
        once = (0.2 * STANDING) ** 2 * exp(min(0.5 * surprise, 20.0))
        return once * _STANDS / self._noise.step  # however long they stand, that they are locked is one doubt

    def _smoothed(self) -> list[float] | None:
        """Return the torques [N m] as the rates of two steps weigh what three do; None unless they are known.

        A torque that alternates moves no wheel for as long.
        """
        if not self.told:
            return None
        first, second, third = self._torques
        return (0.25 * first + 0.5 * second + 0.25 * third).tolist()

    def _lasting(
        self,
        speed: float,
        covariance: Array,
        compliance: Array,
        forces: Forces,
        radius_doubt: Array | float,
        late: Array,
    ) -> Array:
        """Return the variances of rim speeds by what lasts [m^2/s^2], shape (2, wheels); `late`: by late pressures."""
        p, fast = self._noise, max(abs(speed), SLOWEST)
        # To second order: while neither slip over force nor the engine's force is known, their product is an error.
        unknown = np.diagonal(covariance)
        both = unknown[C : self._e] * unknown[F] * (forces.by_engine * fast) ** 2
        of_radius = (p.radius**2 + np.square(radius_doubt)) * fast**2
        lasting = (compliance * forces.doubt * fast) ** 2 + late + of_radius
        return lasting + both / np.maximum(self._untold, p.correlation / p.engine_time)

    def _apply(
        self,
        bank: FilterBank,
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
            bank: the filters.
            z: rim speeds [m/s], shape (wheels,).
            use: which of them count.
            by_engine: change of the forces with f, shape (2, wheels).
            once: variance of what is drawn anew in each step [m^2/s^2], shape (wheels,).
            lasting: variance of what lasts for `many` steps [m^2/s^2], shape (2, wheels).
            many: see `lasting`.
            age: of z at the last step [s].
            way: integral of the readings since then [m/s].
        """
        then, by_then = speed_before(bank.x, age, way)
        expected, h = self.equation.expected(then, by_then, bank.x, self._tyres.force[ROW], by_engine[ROW])
        h[:, ~use] = 0.0
        innovation = np.where(use, z - expected, 0.0)
        sound = np.where(use, once + lasting[ROW] * many, 1.0)
        # One that has failed, or spins beyond any slip, is not explained by any state, and is not believed for a while.
        lasts = self._noise.failed / self._noise.step
        failed = bank.doubt(h, innovation, sound, self.failed, self._noise.surprise, lasts)
        self.failed = failed * exp(-1.0 / lasts)
        before = bank.x
        misfits = bank.correct(h, innovation, sound + failed, self._noise.quiet)
        self.odds.contradict(float(misfits[MISTOLD]) - np.count_nonzero(use))
        self._keep_open(bank, before)

    def _keep_open(self, bank: FilterBank, before: Array) -> None:
        """Keep open what rim speeds do not tell: an error of all radii alike, with speed and yaw rate in proportion."""
        x, p, share = bank.x, bank.p, 1.0 / self._count
        alike = 1.0 + share * (x - before)[:, self._e :].sum(axis=1)
        for state in (V, U):
            moved = (share * (x[:, state] - before[:, state] * alike))[:, None]
            p[:, state] += moved * p[:, self._e :].sum(axis=1)
            p[:, :, state] += moved * p[:, :, self._e :].sum(axis=2)

    def _keep_signs(self, bank: FilterBank, late: Array) -> None:
        """Move a slip that is against its force to zero, with what goes with it; what is known stays as it is."""
        x, covariance = bank.x, bank.p
        force = np.abs(self._tyres.force[ROW])
        reach = np.abs(x[:, V, None]) * force
        against = (force > TELLING) & (x[:, C : self._e] * reach < -late)
        if not against.any():
            return
        for m, i in np.argwhere(against):
            least = -late[m, i] / max(reach[m, i], 1e-6)
            if x[m, C + i] < least:  # the move of a wheel before it has moved this one too
                x[m] -= covariance[m, :, C + i] / covariance[m, C + i, C + i] * (x[m, C + i] - least)
