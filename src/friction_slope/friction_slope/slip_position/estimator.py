"""Probability that each wheel of a car is beyond the peak of its friction curve, sample by sample.

Samples move slips and loads; each block of them is evidence for the hypotheses; and at every sample

    P(beyond) = sum over h of w_h Phi((sigma - lambda_h) / stddev)

where sigma is the combined slip that the tyre has built up. The probability is of the stamp: it has no delay.
"""

from dataclasses import dataclass
from math import isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_slope.slip_position.blocks import SPEED_AGE, WHEEL_SPEED_STDDEV, Blocks
from friction_slope.slip_position.common_road import joint_weights, own_weights
from friction_slope.slip_position.curve_shapes import LAMBDA_MAX, SHAPES, STEP
from friction_slope.slip_position.hypotheses import LEAST_SPEED, MU, RELAXATION, SPEED, Hypotheses
from friction_slope.slip_position.lateral_slip import LateralSlip
from friction_slope.slip_position.wheel_loads import WheelLoads
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import LateralForces, Sideslip
from vehicle_models.nanoseconds import NANOSECOND
from vehicle_models.physical_bounds import HIGHEST_ROAD_FRICTION
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SLOWEST: Final = 1.0
"""Speed that divides the slips of a slower car [m/s]."""
SLOWEST_EVIDENCE: Final = 2.5
"""Speed of the car up to which blocks are no evidence [m/s]."""
_GRID: Final = 0.3 * STEP
"""Deviation of lambda_max within a step of the hypotheses, relative."""
_PER_SLIP: Final = (-1, LAMBDA_MAX.size, len(SHAPES))
_HARDEST: Final = HIGHEST_ROAD_FRICTION * GRAVITY
_LEAST_WEIGHT: Final = 1e-200


@dataclass(frozen=True)
class CarSample:
    """Sample of a car, arrays of shape (n,) in the order of its wheels."""

    stamp: int
    """[ns]"""
    wheel_speed: Array
    """[rad/s]"""
    torque: Array
    """Of the brakes [N m]; NaN: not known, as all that follow."""
    slip: Array
    """Kinematic slips, braking positive [-]."""
    slip_stddev: Array
    ground_speed: Array
    """Of the car at each wheel [m/s]."""
    forward: float = nan
    """Acceleration of the car [m/s^2]."""
    leftward: float = nan
    """Its lateral acceleration [m/s^2]."""
    yaw_rate: float = nan
    """Counter-clockwise [rad/s]."""


class SlipPosition:
    """Where the slips of all wheels stand."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin without evidence."""
        self._n = len(vehicle.wheels)
        self._mass, self._track = vehicle.mass, vehicle.track
        self._length = np.array([wheel.relaxation_length for wheel in vehicle.wheels])
        self._radius = np.array(vehicle.radii)
        self._left = np.array([wheel.side == "left" for wheel in vehicle.wheels])
        driven = np.array([wheel.driven for wheel in vehicle.wheels])
        self._drag = np.where(driven, vehicle.engine_drag_torque, 0.0)
        self._loads, self._lateral = WheelLoads(vehicle), LateralSlip(vehicle)
        self._lateral_forces, self._sideslip = LateralForces(vehicle), Sideslip()
        self._blocks, self._hypotheses = Blocks(vehicle), Hypotheses(vehicle)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._loads.reset()
        self._lateral.reset()
        self._lateral_forces.reset()
        self._sideslip.begin_braking()
        self._stamp: int | None = None
        self._known = np.zeros(self._n, dtype=bool)
        self._braked = np.zeros(self._n, dtype=bool)
        self.slip: Array = np.zeros(self._n)
        """Slip along each wheel that its tyre has built up [-], shape (n,)."""
        self._by_length: Array = np.zeros(self._n)
        """Its derivative by the relaxation length [1/m], shape (n,)."""
        self._kinematic: Array = np.zeros(self._n)
        self._by_ground_speed: Array = np.zeros(self._n)
        """Derivative of the kinematic slip by the ground speed [s/m], shape (n,)."""
        self._slip_noise: Array = np.zeros(self._n)
        """Deviation of the kinematic slip by the white noise of the wheel speed [-], shape (n,)."""
        self._growth: Array = np.zeros(self._n)
        """What the tyre has built up of the rest of its slip within the age of a wheel speed [-], shape (n,)."""
        self._forces = np.zeros(self._n)
        self._seen = np.zeros(self._n, dtype=bool)
        """Wheels with evidence since the braking began or the road changed; a locked wheel needs none."""
        self._speed_variance = np.full(self._n, LEAST_SPEED**2)
        for wheel in range(self._n):
            self._hypotheses.begin(wheel, 0.0)
        self._weigh()
        self._sum_up()

    @property
    def unevenness(self) -> Array:
        """Relative deviation of the loads that explains the measured frictions [-], shape (n,)."""
        return self._hypotheses.unevenness

    @property
    def slides(self) -> bool:
        """Whether the car slides sideways since it brakes."""
        return self._sideslip.slides

    def update(self, sample: CarSample, braked: Flags) -> Array:
        """Take a sample, later than the last; return P(beyond the peak), shape (n,), NaN without evidence.

        Args:
            sample: what is measured.
            braked: wheels that count as braked, shape (n,).
        """
        known = np.isfinite(sample.slip + sample.wheel_speed + sample.torque)
        speed = np.maximum(np.where(known, sample.ground_speed, SLOWEST), SLOWEST)
        kinematic = np.where(known, np.minimum(sample.slip, 1.0), self._kinematic)
        wheel_speed = np.where(known, sample.wheel_speed, 0.0)
        torque = np.where(known, sample.torque, 0.0) + self._drag
        stddev = np.where(known, sample.slip_stddev, 0.0) * speed
        self._by_ground_speed = (1.0 - kinematic) / speed
        self._slip_noise = self._radius * WHEEL_SPEED_STDDEV / speed
        any_braked = bool(braked.any())
        if any_braked:
            self._begin_braking(braked, stddev)
        car_speed = float(speed.sum()) / self._n
        if self._stamp is None:
            self.slip = kinematic.copy()
            self._blocks.begin(wheel_speed, torque, kinematic)
        else:
            dt = (sample.stamp - self._stamp) * NANOSECOND
            self._relax(dt, speed, kinematic, known)
            measured = self._move(dt, sample, speed, car_speed, known)
            if any_braked and car_speed > SLOWEST_EVIDENCE:
                self._gather(dt, wheel_speed, torque, kinematic, stddev, known & braked, measured)
            else:
                self._blocks.begin(wheel_speed, torque, kinematic)
        self._stamp, self._known, self._kinematic = sample.stamp, known, kinematic
        if not any_braked:
            self._braked = braked
            return np.full(self._n, nan)
        judged = known & braked & (self._seen | (self.slip > LAMBDA_MAX[-1]))
        return np.where(judged, self._probability(kinematic), nan)

    def _begin_braking(self, braked: Flags, stddev: Array) -> None:
        """Begin anew with the wheels that are braked and were not; `stddev` is that of their ground speeds [m/s]."""
        begun, rolled = braked & ~self._braked, not self._braked.any()
        self._braked = braked
        if not begun.any():
            return
        if rolled:
            self._sideslip.begin_braking()
        self._seen &= ~begun
        self._speed_variance = np.where(begun, np.maximum(stddev, LEAST_SPEED) ** 2, self._speed_variance)
        for wheel in np.flatnonzero(begun):
            self._hypotheses.begin(int(wheel), float(stddev[wheel]))
        self._weigh()
        self._sum_up()

    def _relax(self, dt: float, speed: Array, kinematic: Array, known: Flags) -> None:
        """Let the tyres follow the slips, which change linearly in the step; one that comes back begins anew."""
        rolled = dt * speed / self._length
        kept = np.exp(-rolled)
        mean = (1.0 - kept) / rolled
        self._growth = SPEED_AGE * dt * speed / self._length
        followed = kept * self.slip + (mean - kept) * self._kinematic + (1.0 - mean) * kinematic
        change = kept * rolled * (self.slip - self._kinematic) + (mean - kept) * (self._kinematic - kinematic)
        by_length = kept * self._by_length + change / self._length
        follows = known & self._known
        self.slip = np.where(follows, followed, kinematic)
        self._by_length = np.where(follows, by_length, 0.0)

    def _move(self, dt: float, sample: CarSample, speed: Array, car_speed: float, known: Flags) -> bool:
        """Move loads and lateral forces; return whether the motion across is measured."""
        forward = sample.forward
        if not isfinite(forward):
            forward = -float(self._forces.sum()) / self._mass
        yaw_rate, leftward = sample.yaw_rate, sample.leftward
        measured = isfinite(yaw_rate) and isfinite(leftward)
        if not measured:
            yaw_rate = 0.0
            if self._lateral_forces.known and known.all():
                yaw_rate = float(speed[~self._left].mean() - speed[self._left].mean()) / self._track
            leftward = yaw_rate * car_speed
        forward, leftward = (min(max(each, -_HARDEST), _HARDEST) for each in (forward, leftward))
        self._loads.update(dt, forward, leftward)
        if self._lateral_forces.known:
            self._sideslip.move(dt, car_speed, yaw_rate, leftward)
            self._lateral_forces.move(dt, yaw_rate, leftward, self._forces)
        return measured

    def _gather(
        self,
        dt: float,
        wheel_speed: Array,
        torque: Array,
        kinematic: Array,
        stddev: Array,
        used: Flags,
        measured: bool,
    ) -> None:
        """Add a sample to the block, and take the block as evidence where it is long enough."""
        lateral, loads, found = self._lateral, self._loads, self._hypotheses
        corrected = self.slip[:, np.newaxis] + self._by_length[:, np.newaxis] * found.x[RELAXATION]
        corrected += self._by_ground_speed[:, np.newaxis] * found.x[SPEED]
        if not self._blocks.add(dt, torque, corrected, self._by_length, lateral.slip, loads.loads, loads.delayed, used):
            return
        mu = found.x[MU]
        block, forces = self._blocks.end(
            wheel_speed, kinematic, self._by_ground_speed, self._slip_noise, lateral.slip, lateral.stddev, mu
        )
        self._forces = np.where(used, forces, 0.0)
        # a correction by wheel_slip leaves of its error what is left of the variance, and adds an error of its own
        before, variance = self._speed_variance, np.maximum(stddev, LEAST_SPEED) ** 2
        kept = np.minimum(variance / before, 1.0)
        changed = found.update(block, kept, np.maximum(variance - before, 0.0) + (1.0 - kept) * variance)
        self._speed_variance = variance
        self._seen = (self._seen | block.used) & ~changed
        for wheel in np.flatnonzero(changed):
            found.change_road(int(wheel), float(stddev[wheel]))
        self._weigh()
        if self._lateral_forces.known:
            forces_across = self._lateral_forces.forces
            lateral.solve(block.duration, self.slip, mu, loads.loads, self._weights, forces_across, measured)
        self._sum_up()

    def _weigh(self) -> None:
        found = self._hypotheses
        own = own_weights(found.log_weights)
        self._weights = joint_weights(own, found.x[MU], found.p[MU, MU], self._braked)

    def _sum_up(self) -> None:
        """Sum over the shapes, for each slip of the peak: weight, and what is added to the slip with its covariance."""
        weights = self._weights.reshape(_PER_SLIP)
        self._weight = weights.sum(axis=2)
        share = weights / np.maximum(self._weight, _LEAST_WEIGHT)[:, :, np.newaxis]
        found, lateral = self._hypotheses, self._lateral

        def mean(values: Array) -> Array:
            return np.asarray((share * values.reshape(_PER_SLIP)).sum(axis=2))

        speed, length = found.x[SPEED], found.x[RELAXATION]
        self._speed_error, self._length_error, self._lateral_slip = mean(speed), mean(length), mean(lateral.slip)
        self._speed_error_variance = mean(found.p[SPEED, SPEED] + speed**2) - self._speed_error**2
        self._length_variance = mean(found.p[RELAXATION, RELAXATION] + length**2) - self._length_error**2
        self._covariance = mean(found.p[SPEED, RELAXATION] + speed * length) - self._speed_error * self._length_error
        self._lateral_variance = mean(lateral.stddev**2 + lateral.slip**2) - self._lateral_slip**2

    def _probability(self, kinematic: Array) -> Array:
        along = self.slip[:, np.newaxis]
        sigma = np.maximum(np.hypot(along, self._lateral_slip), 1e-5)
        by_speed = self._by_ground_speed[:, np.newaxis] * along / sigma
        noise = self._slip_noise[:, np.newaxis] ** 2
        by_length = self._by_length[:, np.newaxis] * along / sigma
        variance = by_speed**2 * self._speed_error_variance + by_length**2 * self._length_variance
        variance += 2.0 * by_speed * by_length * self._covariance
        variance += (self._lateral_slip / sigma) ** 2 * self._lateral_variance
        grown = (self._growth * (kinematic - self.slip))[:, np.newaxis] * along / sigma
        away = sigma + grown + by_speed * self._speed_error + by_length * self._length_error - LAMBDA_MAX
        z = away / np.sqrt(variance + grown**2 + noise + (_GRID * LAMBDA_MAX) ** 2)
        z = np.clip(z, -6.0, 6.0)
        # the normal distribution to 2e-4
        beyond = 0.5 + 0.5 * np.tanh(z * (0.7978846 + 0.0356774 * z * z))
        return np.asarray((self._weight * beyond).sum(axis=1))
