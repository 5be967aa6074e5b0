"""Lateral slips of the wheels from the lateral forces of their axles, for each hypothesis about the curve.

With sigma = hypot(s_x, s_y) and the force along the slip, both wheels of an axle share one s_y. The forces of the axles
follow from lateral acceleration, yaw acceleration and the yaw moment M of the brakes:

    F_front = m f a_y + (I yaw'' - M) / l,    F_rear = m (1 - f) a_y - (I yaw'' - M) / l
    s_y = F / (k sum of mu(sigma) Fz / sigma)

s_y is solved on the near branch only, up to the peak. Close to it a force determines no slip: s_y is solved once more
for a force that is two deviations larger, and half the difference is its deviation.
"""

from math import isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_runtime.filters import first_order_gain
from friction_slope.slip_position.curve_shapes import LAMBDA, friction_ratio
from vehicle_models.vehicle import FRONT, Vehicle

Array = NDArray[np.float64]

ACROSS: Final = 0.92
"""Friction of a tyre across over that along [-]: 0.85 to 1."""
FORCE_STDDEV: Final = 0.06
"""Relative deviation of the lateral force of an axle over its friction [-]."""
UNMEASURED_FORCE_STDDEV: Final = 0.5
"""The same where yaw rate and lateral acceleration come from the wheel speeds [-]."""
SMOOTHED: Final = 0.05
"""Time constant of lateral acceleration, yaw acceleration and moment, in step with each other [s]."""
FOLLOWED: Final = 0.03
"""Time in which the tyres follow [s]."""
GYRATION: Final = 0.95
"""Yaw inertia over that of masses at the axles [-]."""
SLIDING: Final = 0.08
"""Change of the sideslip angle since the begin of a braking beyond which the car slides [rad]: no steering moves it."""
ACROSS_STDDEV: Final = 0.2, 0.05
"""Error of a measured lateral acceleration, bias [m/s^2] and by the roll of the body [-], three deviations."""
WIDEST: Final = 2.0
"""Largest s_y of the larger force over lambda_max [-]."""
LEAST_FORCE: Final = 100.0
"""Least friction of an axle [N]."""


class LateralSlip:
    """Lateral slips of four wheels; zero for a car with fewer, whose path is taken for straight."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Begin straight ahead."""
        names = [(wheel.axle, wheel.side) for wheel in vehicle.wheels]
        self.known = len(names) == 4
        """Whether the car has two axles of two wheels."""
        self._n = len(names)
        others = {"left": "right", "right": "left"}
        partners = [names.index((axle, others[side])) for axle, side in names] if self.known else []
        self._partner = np.array(partners, dtype=np.int64)
        self._is_front = np.array([axle == FRONT for axle, _ in names])
        self._lever = np.array([0.5 if side == "left" else -0.5 for _, side in names]) * vehicle.track
        share = vehicle.front_load_share
        self._mass = vehicle.mass * np.where(self._is_front, share, 1.0 - share)
        self._moment = np.where(self._is_front, 1.0, -1.0) / vehicle.wheelbase
        self._inertia = GYRATION * vehicle.mass * share * (1.0 - share) * vehicle.wheelbase**2
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        shape = (self._n, LAMBDA.size)
        self.slip: Array = np.zeros(shape)
        """s_y [-], shape (n, H)."""
        self._larger: Array = np.zeros(shape)
        self.stddev: Array = np.zeros(shape)
        """Of s_y [-], shape (n, H)."""
        self._yaw_rate = self._acceleration = self._brakes = 0.0
        self._begun = False
        self._yaw_acceleration = 0.0
        self.begin_braking()

    def begin_braking(self) -> None:
        """Take the sideslip of now for that of a car that does not slide."""
        self._sideways = self._allowance = 0.0
        self.slides = False
        """Whether the car slides sideways: then force and slip of a wheel are as far from this model as the car is."""

    def move(self, dt: float, speed: float, yaw_rate: float, leftward: float, brake_forces: Array) -> None:
        """Take the motion of the car over a time step.

        Args:
            dt: [s].
            speed: [m/s].
            yaw_rate: [rad/s].
            leftward: acceleration [m/s^2].
            brake_forces: of the wheels [N], (n,).
        """
        self._sideways += dt * (leftward - speed * yaw_rate)
        bias, by_roll = ACROSS_STDDEV
        self._allowance += dt * (bias + by_roll * abs(leftward))
        self.slides = abs(self._sideways) > SLIDING * speed + self._allowance
        if not self._begun:
            self._begun, self._yaw_rate, self._acceleration = True, yaw_rate, leftward
        gain = first_order_gain(dt, SMOOTHED)
        change = gain * (yaw_rate - self._yaw_rate)
        self._yaw_rate += change
        self._yaw_acceleration = change / dt
        self._acceleration += gain * (leftward - self._acceleration)
        if isfinite(moment := float(self._lever @ brake_forces)):
            self._brakes += gain * (moment - self._brakes)

    def solve(self, dt: float, slip: Array, mu: Array, loads: Array, weights: Array, measured: bool) -> None:
        """Follow the forces over a time step.

        Args:
            dt: [s].
            slip: s_x of the tyres [-], shape (n,).
            mu: peak friction of each hypothesis [-], shape (n, H).
            loads: [N], shape (n,).
            weights: of the hypotheses, shape (n, H), sums of 1: the other wheel of the axle is as it probably is.
            measured: whether yaw rate and lateral acceleration are measured.
        """
        force = np.abs(
            self._mass * self._acceleration + self._moment * (self._inertia * self._yaw_acceleration - self._brakes)
        )[:, np.newaxis]
        stddev = FORCE_STDDEV if measured else UNMEASURED_FORCE_STDDEV
        gain = first_order_gain(dt, FOLLOWED)
        for s_y, asked, limit in (
            (self.slip, force, LAMBDA),
            (self._larger, (1.0 + 2.0 * stddev) * force, WIDEST * LAMBDA),
        ):
            sigma = np.maximum(np.hypot(slip[:, np.newaxis], s_y), 0.02 * LAMBDA)
            stiffness = mu * friction_ratio(sigma) * loads[:, np.newaxis] / sigma
            axle = stiffness + (weights * stiffness).sum(axis=1)[self._partner, np.newaxis]
            s_y += gain * (np.minimum(asked / np.maximum(ACROSS * axle, LEAST_FORCE), limit) - s_y)
        self.stddev = 0.5 * np.maximum(self._larger - self.slip, 0.0)
