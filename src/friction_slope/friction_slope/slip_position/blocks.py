"""Blocks of samples: mean friction of each wheel, and what each hypothesis makes of the slips in them.

A wheel acceleration over 20 ms has noise of 5 N m, over a sample of 5 ms of 20 N m; the friction of the curve is the
mean over the same time, sample by sample, as slip grows by half of itself within a block.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_slope.slip_position.curve_shapes import LAMBDA, friction_ratio, friction_ratio_and_slope
from friction_slope.slip_position.hypotheses import Block
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LENGTH: Final = 0.02
"""Shortest block [s]."""
WHEEL_SPEED_STDDEV: Final = 0.07
"""White noise of a wheel speed [rad/s]."""
TORQUE_STDDEV: Final = 3.0
"""White noise of a brake torque [N m]."""
SPEED_AGE: Final = 0.4
"""Age of a wheel speed, at its stamp or the mean since the last: mean and deviation [sample intervals]."""
LOCKED: Final = 0.9
"""Slip from which on a wheel stands: its brake holds it, and not the road [-]."""
LEAST_SIGMA: Final = 1e-5
_LENGTH_MARGIN: Final = 1e-4


class Blocks:
    """Sums of the samples of a block."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Choose a car; `begin` comes first."""
        self._radius = np.array(vehicle.radii)
        self._inertia = np.array([wheel.inertia for wheel in vehicle.wheels])

    def begin(self, wheel_speed: Array, torque: Array, slip: Array) -> None:
        """Begin a block at a sample, arrays of shape (n,)."""
        self._samples, self._duration = 0, 0.0
        self._first = wheel_speed, torque, slip
        self._torque = torque
        self._sums = np.zeros((4, len(slip)))
        self._slip = np.zeros((len(slip), LAMBDA.size))
        self._ratio = np.zeros_like(self._slip)
        self._used = np.ones(len(slip), dtype=bool)

    def add(
        self,
        dt: float,
        torque: Array,
        slip: Array,
        by_length: Array,
        lateral_slip: Array,
        loads: Array,
        delayed: Array,
        used: Flags,
    ) -> bool:
        """Take a sample after a time step; return whether the block is long enough.

        Args:
            dt: [s].
            torque: of the brakes [N m], (n,).
            slip: s_x of the tyres as each hypothesis corrects it [-], (n, H).
            by_length: its derivative by the relaxation length [1/m], (n,).
            lateral_slip: s_y [-], (n, H).
            loads: [N], (n,).
            delayed: load by springs less that by dampers [N], (n,).
            used: wheels that are braked and measured, (n,).
        """
        self._samples += 1
        self._duration += dt
        sigma = np.maximum(np.hypot(slip, lateral_slip), LEAST_SIGMA)
        self._slip += dt * slip
        self._ratio += dt * slip * friction_ratio(sigma) / sigma
        self._sums += dt * np.array([0.5 * (torque + self._torque), by_length, loads, delayed])
        self._torque = torque
        self._used &= used
        return self._duration > LENGTH - _LENGTH_MARGIN

    def end(
        self,
        wheel_speed: Array,
        kinematic: Array,
        by_ground_speed: Array,
        slip_noise: Array,
        lateral_slip: Array,
        lateral_stddev: Array,
        mu: Array,
    ) -> tuple[Block, Array]:
        """Return the block, and the brake forces in it [N], (n,); then begin the next.

        Args:
            wheel_speed: at the last sample [rad/s], (n,).
            kinematic: slip of the wheels at the last sample [-], (n,).
            by_ground_speed: its derivative by the ground speed [s/m], (n,).
            slip_noise: deviation of it by the white noise of the wheel speed [-], (n,).
            lateral_slip: s_y [-], (n, H).
            lateral_stddev: its deviation [-], (n, H).
            mu: peak friction of the hypotheses [-], (n, H).
        """
        duration = self._duration
        torque, by_length, loads, delayed = self._sums / duration
        slip = self._slip / duration
        first_speed, first_torque, first_slip = self._first
        lever = self._radius * loads
        spin = self._inertia * (wheel_speed - first_speed) / duration
        torque_rate = (self._torque - first_torque) / duration
        age = SPEED_AGE * duration / self._samples
        sigma = np.maximum(np.hypot(slip, lateral_slip), LEAST_SIGMA)
        ratio, slope = friction_ratio_and_slope(sigma)
        along, across = slip / sigma, lateral_slip / sigma
        secant = ratio / sigma
        by_slip = slope * along**2 + secant * (1.0 - along**2)
        by_lateral = (slope - secant) * along * across
        # the same for all hypotheses: an error of s_y is no evidence against those that it matters to
        across_spread = ((mu * by_lateral * lateral_stddev) ** 2).mean(axis=1)
        slip_rate = (kinematic - first_slip) / duration
        slip_variance = (age * slip_rate) ** 2 + slip_noise**2 / self._samples
        friction = (spin + torque) / lever
        noise = (np.sqrt(2.0) * self._inertia * WHEEL_SPEED_STDDEV / duration) ** 2 + TORQUE_STDDEV**2 / self._samples
        block = Block(
            duration=duration,
            used=self._used & (kinematic < LOCKED) & (wheel_speed * self._radius > 0.5),
            friction=friction,
            variance=(noise + (age * torque_rate) ** 2) / lever**2,
            spread=(mu * by_slip) ** 2 * slip_variance[:, np.newaxis] + across_spread[:, np.newaxis],
            ratio=self._ratio / duration,
            by_speed=by_slip * by_ground_speed[:, np.newaxis],
            by_relaxation=by_slip * by_length[:, np.newaxis],
            by_delay=-torque_rate / lever,
            by_inertia=-spin / lever,
            by_drag=-1.0 / lever,
            by_transfer=-friction * delayed / loads,
        )
        self.begin(wheel_speed, self._torque, kinematic)
        return block, friction * loads
