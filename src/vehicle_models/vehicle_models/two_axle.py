"""A two-axle rear-wheel-drive car on a straight road: four wheels that share one body.

    J omega_dot_i = r Fx_i - T_i - T_roll_i + T_drive_i,    m v_dot = -sum Fx_i - c v^2 - m g sin(grade),
    Fx_i = Fz_i mu(slip_i),    T_roll_i = c_r r Fz_i,    slip_i = (v - omega_i r) / v,

with braking forces Fx positive, as in the book (2.15), and the loads Fz_i of load_transfer. Left and right wheels of an
axle carry the same load. The same linearly implicit, L-stable method as in single_corner, of second order whatever the
matrix (Verwer's ROS2): the matrix here leaves out the change of load, and is an arrow that solves in closed form.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import burckhardt, load_transfer
from vehicle_models.single_corner import GRAVITY, REST_SPEED, ROSENBROCK_GAMMA, SLIP_SPEED_FLOOR

Array = NDArray[np.float64]

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
"""Order of the last dimension of every array per wheel."""


@dataclass(frozen=True)
class CarParameters:
    """The car."""

    mass: float = 1500.0
    """[kg]"""
    radius: float = 0.3
    """Effective rolling radius of every wheel [m]."""
    inertia: float = 1.0
    """Of each wheel [kg m^2]."""
    wheelbase: float = 2.7
    """[m]"""
    height: float = 0.5
    """Of the centre of gravity [m]."""
    front_share: float = 0.5
    """Share of the weight on the front axle at rest."""
    front_braking: float = 0.65
    """Share of the brake torque on the front axle."""
    drag_area: float = 0.65
    """Drag coefficient times frontal area [m^2]."""
    air_density: float = 1.2
    """[kg/m^3]"""
    rolling_resistance: float = 0.012
    """Coefficient of rolling resistance c_r [-]."""
    gravity: float = GRAVITY
    """[m/s^2]"""

    def __post_init__(self) -> None:
        """Refuse values that make no car."""
        positive = (self.mass, self.radius, self.inertia, self.wheelbase, self.gravity)
        if not all(value > 0.0 for value in positive):
            raise ValueError(f"mass, radius, inertia, wheelbase and gravity must be > 0: {self}")
        if not (self.height >= 0.0 and self.drag_area >= 0.0 and self.air_density >= 0.0):
            raise ValueError(f"height, drag_area and air_density must be >= 0: {self}")
        if not (0.0 < self.front_share < 1.0 and 0.0 <= self.front_braking <= 1.0 and self.rolling_resistance >= 0.0):
            raise ValueError(f"front_share must be in (0, 1), front_braking in [0, 1], rolling_resistance >= 0: {self}")

    @property
    def height_ratio(self) -> float:
        """Height over wheelbase, h / L [-]."""
        return self.height / self.wheelbase

    def wheel_loads(self, acceleration: ArrayLike) -> Array:
        """Vertical loads [N] of the wheels, shape (..., 4), under `acceleration` [m/s^2] of shape (...)."""
        front, rear = load_transfer.axle_loads(
            acceleration, self.mass, self.front_share, self.height_ratio, self.gravity
        )
        return np.stack([0.5 * front, 0.5 * front, 0.5 * rear, 0.5 * rear], axis=-1)

    def split_torque(self, total: ArrayLike) -> Array:
        """Brake torques [N m] of the wheels, shape (..., 4), for the torque `total` of all brakes, shape (...)."""
        shares = np.array([self.front_braking, self.front_braking, 1.0 - self.front_braking, 1.0 - self.front_braking])
        return np.asarray(0.5 * shares * np.asarray(total, dtype=np.float64)[..., np.newaxis])

    def peak_torque(self, theta: ArrayLike) -> Array:
        """Brake torques [N m] that hold every wheel at the peak of the road `theta`, shape (..., 4).

        Drag and rolling resistance are left out.
        """
        lambda_max, mu_max = burckhardt.peak(theta)
        loads = self.wheel_loads(-mu_max * self.gravity)
        inertial = self.inertia * (1.0 - lambda_max) * mu_max * self.gravity / self.radius
        return np.asarray(mu_max[..., np.newaxis] * self.radius * loads + inertial[..., np.newaxis])


class TwoAxleCar:
    """State of n cars (Monte Carlo runs) that share their parameters."""

    def __init__(
        self,
        parameters: CarParameters,
        speed: ArrayLike,
        wheel_speed: ArrayLike | None = None,
        *,
        grade: ArrayLike = 0.0,
        max_step: float = 1e-3,
    ) -> None:
        """Start at `speed` [m/s], shape (n,).

        Args:
            parameters: of the cars.
            speed: >= 0, shape (n,).
            wheel_speed: [rad/s], >= 0, broadcasts to (n, 4); rolling without slip when None.
            grade: slope of the road [rad], uphill positive, broadcasts to (n,); may be set at any time.
            max_step: longest inner step [s], > 0.

        Raises:
            ValueError: a speed is negative or not finite, or max_step is not positive.
        """
        self.parameters = parameters
        self.speed: Array = np.atleast_1d(np.asarray(speed, dtype=np.float64)).copy()
        """Vehicle speed v [m/s], shape (n,)."""
        rolling = self.speed[:, np.newaxis] / parameters.radius if wheel_speed is None else wheel_speed
        shape = (*self.speed.shape, len(WHEELS))
        self.wheel_speed: Array = np.broadcast_to(np.asarray(rolling, dtype=np.float64), shape).copy()
        """Wheel speeds omega [rad/s], shape (n, 4)."""
        self.distance: Array = np.zeros_like(self.speed)
        """Distance covered [m], shape (n,)."""
        self.grade: ArrayLike = grade
        if not (np.all(self.speed >= 0.0) and np.all(self.wheel_speed >= 0.0)):
            raise ValueError("speed and wheel_speed must be finite and >= 0")
        if not max_step > 0.0:
            raise ValueError(f"max_step must be > 0, is {max_step}")
        self._max_step = max_step

    @property
    def slip(self) -> Array:
        """Slip lambda [-] of the wheels, shape (n, 4); relative to 0.1 m/s below that speed, so 0 at rest."""
        return self._slip(self.speed, self.wheel_speed)

    def friction(self, theta: ArrayLike) -> Array:
        """Friction coefficients [-] at the present slips, shape (n, 4)."""
        return burckhardt.friction(_per_wheel(theta), self.slip)

    def acceleration(self, theta: ArrayLike) -> Array:
        """Vehicle acceleration v_dot [m/s^2], negative in braking, shape (n,)."""
        return self._acceleration(self.speed, self.friction(theta))

    def specific_force(self, theta: ArrayLike) -> Array:
        """What an accelerometer along the car reads [m/s^2]: v_dot + g sin(grade), shape (n,)."""
        return np.asarray(self.acceleration(theta) + self.parameters.gravity * np.sin(self.grade))

    def wheel_loads(self, theta: ArrayLike) -> Array:
        """Vertical loads [N] at the present acceleration, shape (n, 4)."""
        return self.parameters.wheel_loads(self.acceleration(theta))

    def wheel_acceleration(self, theta: ArrayLike, brake_torque: ArrayLike, drive_torque: ArrayLike = 0.0) -> Array:
        """Wheel accelerations [rad/s^2], shape (n, 4); 0 while a wheel is locked. Arguments as in step."""
        torque = self._net_torque(brake_torque, drive_torque)
        _, free = self._derivative(self.speed, self.wheel_speed, torque, _per_wheel(theta))
        return np.where((self.wheel_speed <= 0.0) & (free < 0.0), 0.0, free)

    def step(
        self,
        torque_begin: ArrayLike,
        torque_end: ArrayLike,
        theta: ArrayLike,
        dt: float,
        drive_torque: ArrayLike = 0.0,
    ) -> None:
        """Advance by `dt` [s] under brake torques [N m] that run linearly from begin to end, on the road `theta`.

        Brakes and rolling resistance only oppose rolling: a wheel stops at zero speed and stays there while they exceed
        friction and drive.

        Args:
            torque_begin: of each wheel, >= 0, broadcasts to (n, 4).
            torque_end: of each wheel, >= 0, broadcasts to (n, 4).
            theta: shape (3,), one road for all; (n, 3), one a car; or (n, 4, 3), one a wheel.
            dt: > 0.
            drive_torque: on the rear axle [N m], negative for engine braking, broadcasts to (n,); an open differential.
        """
        steps = max(1, int(np.ceil(dt / self._max_step - 1e-9)))
        h = dt / steps
        begin, end = self._net_torque(torque_begin, drive_torque), self._net_torque(torque_end, drive_torque)
        rate = (end - begin) / dt
        road = _per_wheel(theta)
        for k in range(steps):
            speed_before = self.speed
            self._rosenbrock(begin + rate * (k * h), rate, road, h)
            self.distance = self.distance + 0.5 * h * (speed_before + self.speed)

    def _net_torque(self, brake_torque: ArrayLike, drive_torque: ArrayLike) -> Array:
        """Brake minus drive [N m], shape (n, 4)."""
        net = np.broadcast_to(np.asarray(brake_torque, dtype=np.float64), self.wheel_speed.shape).copy()
        net[:, 2:] -= 0.5 * np.broadcast_to(np.asarray(drive_torque, dtype=np.float64), self.speed.shape)[:, np.newaxis]
        return net

    @staticmethod
    def _reference(speed: Array) -> Array:
        return np.maximum(speed, SLIP_SPEED_FLOOR)[:, np.newaxis]

    def _slip(self, speed: Array, wheel_speed: Array) -> Array:
        return np.asarray((speed[:, np.newaxis] - wheel_speed * self.parameters.radius) / self._reference(speed))

    def _acceleration(self, speed: Array, friction: Array) -> Array:
        p = self.parameters
        drag = 0.5 * p.air_density * p.drag_area / p.mass * speed**2
        return load_transfer.acceleration(
            0.5 * (friction[:, 0] + friction[:, 1]),
            0.5 * (friction[:, 2] + friction[:, 3]),
            drag + p.gravity * np.sin(self.grade),
            p.front_share,
            p.height_ratio,
            p.gravity,
        )

    def _derivative(self, speed: Array, wheel_speed: Array, torque: Array, theta: Array) -> tuple[Array, Array]:
        p = self.parameters
        friction = burckhardt.friction(theta, self._slip(speed, wheel_speed))
        acceleration = self._acceleration(speed, friction)
        loads = p.wheel_loads(acceleration)
        moment = p.radius * loads * (friction - p.rolling_resistance)
        return acceleration, (moment - torque) / p.inertia

    def _rosenbrock(self, torque: Array, torque_rate: Array, theta: Array, h: float) -> None:
        p = self.parameters
        v, w = self.speed, self.wheel_speed
        reference = self._reference(v)
        loads = p.wheel_loads(self._acceleration(v, burckhardt.friction(theta, self._slip(v, w))))
        # Beyond the peak the true slope would make the implicit step divide by zero; any matrix keeps the second order.
        slope = loads * np.maximum(burckhardt.slope(theta, self._slip(v, w)), 0.0)
        force_v = slope * np.where(v[:, np.newaxis] > SLIP_SPEED_FLOOR, w * p.radius / reference**2, 1.0 / reference)
        force_w = -slope * p.radius / reference
        f_v, f_w = self._derivative(v, w, torque, theta)
        # A locked wheel has no equation: left in, its pull below zero would reach the body through the matrix.
        turns = (w > 0.0) | (f_w >= 0.0)
        gh = ROSENBROCK_GAMMA * h
        by_wheel = np.where(turns, gh * force_w / p.mass, 0.0)
        wheel_by_v = np.where(turns, -gh * p.radius * force_v / p.inertia, 0.0)
        wheel_own = 1.0 - np.where(turns, gh * p.radius * force_w / p.inertia, 0.0)
        body = 1.0 + gh * force_v.sum(axis=1) / p.mass - (by_wheel * wheel_by_v / wheel_own).sum(axis=1)

        def solve(b_v: Array, b_w: Array) -> tuple[Array, Array]:
            b_w = np.where(turns, b_w, 0.0)
            x_v = (b_v - (by_wheel * b_w / wheel_own).sum(axis=1)) / body
            return x_v, (b_w - wheel_by_v * x_v[:, np.newaxis]) / wheel_own

        time_term = -gh * torque_rate / p.inertia
        k1_v, k1_w = solve(f_v, f_w + time_term)
        f_v, f_w = self._derivative(v + h * k1_v, np.maximum(w + h * k1_w, 0.0), torque + h * torque_rate, theta)
        k2_v, k2_w = solve(f_v - 2.0 * k1_v, f_w - 2.0 * k1_w - time_term)
        speed = v + h * (1.5 * k1_v + 0.5 * k2_v)
        wheel_speed = w + h * (1.5 * k1_w + 0.5 * k2_w)
        standing = (speed < REST_SPEED) & (speed <= v)
        self.speed = np.where(standing, 0.0, speed)
        self.wheel_speed = np.where(standing[:, np.newaxis], 0.0, np.maximum(wheel_speed, 0.0))


def _per_wheel(theta: ArrayLike) -> Array:
    """Road parameters that broadcast with slips of shape (n, 4)."""
    road = np.asarray(theta, dtype=np.float64)
    return road[:, np.newaxis, :] if road.ndim == 2 else road
