"""Single-corner braking dynamics, equations (2.15) and (2.18).

    J omega_dot = r Fx - T_b,    m v_dot = -Fx,    Fx = Fz mu(slip),    slip = (v - omega r) / v,

with the braking force Fx positive, as in the book. The wheel pole grows as 1/v, so an explicit method fails at low
speed; a linearly implicit, L-stable method of second order (Rosenbrock, gamma = 1 - 1/sqrt(2)) is stable down to
standstill.
"""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import burckhardt
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]
Pair = tuple[Array, Array]
"""Something of the body and of the wheels."""

GAMMA = 1.0 - 1.0 / np.sqrt(2.0)
"""Makes the two-stage method of second order and L-stable."""


def check_start(speed: Array, wheel_speed: Array, max_step: float) -> None:
    """Refuse a state or an inner step [s] that no plant can start from.

    Raises:
        ValueError: a speed [m/s, rad/s] is negative or not finite, or max_step is not positive.
    """
    if not (np.all(speed >= 0.0) and np.all(wheel_speed >= 0.0)):
        raise ValueError("speed and wheel_speed must be finite and >= 0")
    if not max_step > 0.0:
        raise ValueError(f"max_step must be > 0, is {max_step}")


def inner_steps(dt: float, max_step: float) -> tuple[int, float]:
    """Number and length [s] of the equal inner steps, none above `max_step` [s], that make up `dt` [s]."""
    steps = max(1, int(np.ceil(dt / max_step - 1e-9)))
    return steps, dt / steps


def two_stages(
    state: Pair,
    derivative: Pair,
    time_term: Array,
    h: float,
    solve: Callable[[Array, Array], Pair],
    derivative_at_end: Callable[[Array, Array], Pair],
) -> Pair:
    """State after a step of the Rosenbrock method with GAMMA, before what stands or is locked is held at rest.

    Args:
        state: speed [m/s] and wheel speeds [rad/s].
        derivative: of the state [m/s^2, rad/s^2].
        time_term: GAMMA h times the derivative of the wheel accelerations by time [rad/s^2].
        h: length of the step [s].
        solve: of the linear system of a stage, for a right-hand side of body and wheels.
        derivative_at_end: of a state at the end of the step, as `derivative`; takes no wheel speed below 0.
    """
    v, w = state
    f_v, f_w = derivative
    k1_v, k1_w = solve(f_v, f_w + time_term)
    f_v, f_w = derivative_at_end(v + h * k1_v, np.maximum(w + h * k1_w, 0.0))
    k2_v, k2_w = solve(f_v - 2.0 * k1_v, f_w - 2.0 * k1_w - time_term)
    return v + h * (1.5 * k1_v + 0.5 * k2_v), w + h * (1.5 * k1_w + 0.5 * k2_w)


SLIP_SPEED_FLOOR: Final = 0.1
"""Below this speed [m/s] slip is taken relative to it: the tyre then acts as a stiff damper."""
REST_SPEED: Final = 1e-3
"""Below this speed [m/s] a braked corner stands."""


class _Corners(NamedTuple):
    """Parameters of n corners, each of shape () if they are the same for all, else (n,)."""

    radius: Array
    inertia: Array
    mass: Array
    vertical_load: Array
    gravity: Array

    @classmethod
    def of(cls, parameters: CornerParameters | Sequence[CornerParameters]) -> "_Corners":
        def values(name: str) -> Array:
            if isinstance(parameters, CornerParameters):
                return np.asarray(getattr(parameters, name), dtype=np.float64)
            return np.array([getattr(each, name) for each in parameters], dtype=np.float64)

        return cls(*map(values, cls._fields))


class SingleCorner:
    """State of n corners (wheels or Monte Carlo runs)."""

    def __init__(
        self,
        parameters: CornerParameters | Sequence[CornerParameters],
        speed: ArrayLike,
        wheel_speed: ArrayLike | None = None,
        *,
        max_step: float = 1e-3,
    ) -> None:
        """Start at `speed`.

        Args:
            parameters: one set for all corners, or n of them, one for each.
            speed: vehicle speed [m/s], >= 0, shape (n,).
            wheel_speed: wheel speed [rad/s], >= 0, broadcasts to (n,); rolling without slip when None.
            max_step: longest inner step [s], > 0.

        Raises:
            ValueError: a speed is negative or not finite, or max_step is not positive.
        """
        self._parameters = _Corners.of(parameters)
        self.speed: Array = np.atleast_1d(np.asarray(speed, dtype=np.float64)).copy()
        """Vehicle speed v [m/s]."""
        rolling = self.speed / self._parameters.radius if wheel_speed is None else wheel_speed
        self.wheel_speed: Array = np.broadcast_to(np.asarray(rolling, dtype=np.float64), self.speed.shape).copy()
        """Wheel speed omega [rad/s]."""
        self.distance: Array = np.zeros_like(self.speed)
        """Distance covered [m]."""
        check_start(self.speed, self.wheel_speed, max_step)
        self._max_step = max_step

    @property
    def slip(self) -> Array:
        """Slip lambda [-], shape (n,); relative to 0.1 m/s below that speed, so 0 at rest."""
        return self._slip(self.speed, self.wheel_speed)

    def friction(self, theta: ArrayLike) -> Array:
        """Friction coefficient [-] at the present slip, shape (n,)."""
        return burckhardt.friction(theta, self.slip)

    def acceleration(self, theta: ArrayLike) -> Array:
        """Vehicle acceleration v_dot [m/s^2], negative in braking, shape (n,)."""
        return -self._parameters.gravity * self.friction(theta)

    def wheel_acceleration(self, theta: ArrayLike, brake_torque: ArrayLike) -> Array:
        """Wheel acceleration omega_dot [rad/s^2] under `brake_torque` [N m], shape (n,); 0 when locked."""
        p = self._parameters
        free = (
            p.radius * p.vertical_load * self.friction(theta) - np.asarray(brake_torque, dtype=np.float64)
        ) / p.inertia
        return np.where((self.wheel_speed <= 0.0) & (free < 0.0), 0.0, free)

    def step(self, torque_begin: ArrayLike, torque_end: ArrayLike, theta: ArrayLike, dt: float) -> None:
        """Advance by `dt` [s] under a brake torque [N m] that changes linearly, on the road `theta`.

        The brake only opposes rolling: a wheel stops at zero speed and stays there while the torque exceeds the
        friction moment.

        Args:
            torque_begin: torque at the start [N m], shape (n,) or scalar, >= 0.
            torque_end: torque at the end [N m], shape (n,) or scalar, >= 0.
            theta: Burckhardt parameters, shape (3,) or (n, 3).
            dt: step [s], > 0.
        """
        steps, h = inner_steps(dt, self._max_step)
        begin = np.asarray(torque_begin, dtype=np.float64)
        rate = (np.asarray(torque_end, dtype=np.float64) - begin) / dt
        for k in range(steps):
            speed_before = self.speed
            self._rosenbrock(begin + rate * (k * h), rate, np.asarray(theta, dtype=np.float64), h)
            self.distance = self.distance + 0.5 * h * (speed_before + self.speed)

    @staticmethod
    def _reference(speed: Array) -> Array:
        return np.maximum(speed, SLIP_SPEED_FLOOR)

    def _slip(self, speed: Array, wheel_speed: Array) -> Array:
        return np.asarray((speed - wheel_speed * self._parameters.radius) / self._reference(speed))

    def _derivative(self, speed: Array, wheel_speed: Array, torque: Array, theta: Array) -> tuple[Array, Array]:
        p = self._parameters
        force = p.vertical_load * burckhardt.friction(theta, self._slip(speed, wheel_speed))
        return -force / p.mass, (p.radius * force - torque) / p.inertia

    def _rosenbrock(self, torque: Array, torque_rate: Array, theta: Array, h: float) -> None:
        p = self._parameters
        v, w = self.speed, self.wheel_speed
        reference = self._reference(v)
        slope = p.vertical_load * burckhardt.slope(theta, self._slip(v, w))
        force_v = slope * np.where(v > SLIP_SPEED_FLOOR, w * p.radius / reference**2, 1.0 / reference)
        force_w = -slope * p.radius / reference
        f_v, f_w = self._derivative(v, w, torque, theta)
        # A locked wheel has no equation: left in, its pull below zero would reach the body through the matrix.
        turns = (w > 0.0) | (f_w >= 0.0)
        gh = GAMMA * h
        a11, a12 = 1.0 + gh * force_v / p.mass, np.where(turns, gh * force_w / p.mass, 0.0)
        a21 = np.where(turns, -gh * p.radius * force_v / p.inertia, 0.0)
        a22 = 1.0 - np.where(turns, gh * p.radius * force_w / p.inertia, 0.0)
        determinant = a11 * a22 - a12 * a21

        def solve(b1: Array, b2: Array) -> tuple[Array, Array]:
            b2 = np.where(turns, b2, 0.0)
            return (a22 * b1 - a12 * b2) / determinant, (a11 * b2 - a21 * b1) / determinant

        def derivative_at_end(speed: Array, wheel_speed: Array) -> tuple[Array, Array]:
            return self._derivative(speed, wheel_speed, torque + h * torque_rate, theta)

        time_term = -gh * torque_rate / p.inertia
        speed, wheel_speed = two_stages((v, w), (f_v, f_w), time_term, h, solve, derivative_at_end)
        standing = speed < REST_SPEED
        self.speed = np.where(standing, 0.0, speed)
        self.wheel_speed = np.where(standing, 0.0, np.maximum(wheel_speed, 0.0))


class JoinedCorners:
    """Corners, (2.15), that carry one body: they share its speed and do not shift load.

    The corners are integrated each on its own over a sample; then the body takes the mean of their speeds, weighted by
    their masses, which conserves momentum. One corner alone is exactly the single-corner model.
    """

    def __init__(self, parameters: Sequence[CornerParameters], speed: float) -> None:
        """Start free rolling at `speed` [m/s]; `parameters` holds those of each corner."""
        self._parameters = tuple(parameters)
        self._corners = SingleCorner(self._parameters, np.full(len(self._parameters), speed))
        # relative to the first: of equal corners the weighted mean is the plain one, to the last bit
        self._weights = np.array([each.mass for each in self._parameters]) / self._parameters[0].mass

    @property
    def speed(self) -> float:
        """Speed of the body [m/s]."""
        return float(self._corners.speed[0])

    @property
    def distance(self) -> Array:
        """Distance covered [m], shape (n,)."""
        return self._corners.distance

    @property
    def wheel_speed(self) -> Array:
        """Wheel speeds [rad/s], shape (n,)."""
        return self._corners.wheel_speed

    @property
    def slip(self) -> Array:
        """Slips [-], shape (n,)."""
        return self._corners.slip

    @property
    def radius(self) -> Array:
        """Radii [m], shape (n,)."""
        return np.array([each.radius for each in self._parameters])

    @property
    def inertia(self) -> Array:
        """Wheel inertias [kg m^2], shape (n,)."""
        return np.array([each.inertia for each in self._parameters])

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds the first wheel at the peak of the road theta, shape (3,)."""
        return float(self._parameters[0].peak_torque(theta))

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (n,)."""
        return np.array([each.vertical_load for each in self._parameters])

    def acceleration(self, theta: Array) -> float:
        """Acceleration of the body [m/s^2]."""
        return self._of_body(self._corners.acceleration(theta))

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (n,)."""
        return self._corners.wheel_acceleration(theta, brake_torque)

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance all corners by dt [s] and join them again."""
        corners = self._corners
        corners.step(torque_begin, torque_end, theta, dt)
        if corners.speed.size > 1:
            corners.speed = np.full_like(corners.speed, self._of_body(corners.speed))
            corners.distance = np.full_like(corners.distance, self._of_body(corners.distance))

    def _of_body(self, of_corners: Array) -> float:
        return float((self._weights * of_corners).sum() / self._weights.sum())
