"""A car on two axles on a straight road: four wheels that share one body.

    J_i omega_dot_i = r_i Fx_i - T_i - T_roll_i + T_drive_i,    m v_dot = -sum Fx_i - c v^2 - m g sin(grade),
    Fx_i = Fz_i mu(slip_i),    T_roll_i = c_r r_i Fz_i,    slip_i = (v - omega_i r_i) / v,

with braking forces Fx positive, as in the book (2.15), and the loads Fz_i of wheel_forces. Left and right wheels of an
axle carry the same load. The same linearly implicit, L-stable method as in single_corner, of second order whatever the
matrix (Verwer's ROS2): the matrix here leaves out the change of load, and is an arrow that solves in closed form.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corner_sim.corner import GAMMA, REST_SPEED, SLIP_SPEED_FLOOR, check_start, inner_steps, two_stages
from vehicle_models import burckhardt
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.wheel_forces import axle_loads

Array = NDArray[np.float64]


def joint_acceleration(
    front_friction: ArrayLike,
    rear_friction: ArrayLike,
    resistance: ArrayLike,
    front_share: float,
    height_ratio: float,
    gravity: float,
) -> Array:
    """Acceleration [m/s^2] of the car, consistent with the loads it causes.

    Args:
        front_friction: mean friction coefficient of the front wheels, positive in braking.
        rear_friction: the same of the rear wheels.
        resistance: deceleration by all else, R / m [m/s^2].
        front_share: f, 0 to 1.
        height_ratio: h / L.
        gravity: [m/s^2].
    """
    front, rear = np.asarray(front_friction, dtype=np.float64), np.asarray(rear_friction, dtype=np.float64)
    driving = gravity * (front_share * front + (1.0 - front_share) * rear) + np.asarray(resistance, dtype=np.float64)
    return np.asarray(-driving / (1.0 - height_ratio * (front - rear)))


def wheel_loads(vehicle: Vehicle, acceleration: ArrayLike) -> Array:
    """Vertical loads [N] of the wheels, shape (..., 4), under `acceleration` [m/s^2] of shape (...)."""
    front, rear = axle_loads(acceleration, vehicle.mass, vehicle.front_load_share, vehicle.height_ratio, GRAVITY)
    loads = np.empty((*front.shape, 4))  # np.stack takes ten times as long
    loads[..., 0] = loads[..., 1] = 0.5 * front
    loads[..., 2] = loads[..., 3] = 0.5 * rear
    return loads


def split_torque(vehicle: Vehicle, total: ArrayLike) -> Array:
    """Brake torques [N m] of the wheels, shape (..., 4), for the torque `total` of all brakes at one pressure."""
    gains = np.array([wheel.brake_gain for wheel in four_wheels(vehicle)])
    return np.asarray(gains / gains.sum() * np.asarray(total, dtype=np.float64)[..., np.newaxis])


def peak_torque(vehicle: Vehicle, theta: ArrayLike) -> Array:
    """Brake torques [N m] that hold every wheel at the peak of the road `theta`, shape (..., 4).

    Drag and rolling resistance are neglected.
    """
    wheels = four_wheels(vehicle)
    radius, inertia = np.array([wheel.radius for wheel in wheels]), np.array([wheel.inertia for wheel in wheels])
    lambda_max, mu_max = (peak[..., np.newaxis] for peak in burckhardt.peak(theta))
    loads = wheel_loads(vehicle, -mu_max[..., 0] * GRAVITY)
    inertial = inertia * (1.0 - lambda_max) * mu_max * GRAVITY / radius
    return np.asarray(mu_max * radius * loads + inertial)


class TwoAxleCar:
    """State of n equal cars (Monte Carlo runs)."""

    def __init__(
        self,
        vehicle: Vehicle,
        speed: ArrayLike,
        wheel_speed: ArrayLike | None = None,
        *,
        grade: ArrayLike = 0.0,
        max_step: float = 1e-3,
    ) -> None:
        """Start at `speed` [m/s], shape (n,).

        Args:
            vehicle: the car; arrays are in the order of four_wheels, whatever the order in `vehicle`.
            speed: speed [m/s], >= 0, shape (n,).
            wheel_speed: wheel speeds [rad/s], >= 0, broadcasts to (n, 4); rolling without slip when None.
            grade: slope of the road [rad], uphill positive, broadcasts to (n,); may be set at any time.
            max_step: longest inner step [s], > 0.

        Raises:
            ValueError: a speed is negative or not finite, max_step is not positive, or the car does not have four
                wheels.
        """
        wheels = four_wheels(vehicle)
        self.vehicle = vehicle
        """The car."""
        self.radius: Array = np.array([wheel.radius for wheel in wheels])
        """Effective rolling radii [m], shape (4,)."""
        self.inertia: Array = np.array([wheel.inertia for wheel in wheels])
        """Wheel inertias [kg m^2], shape (4,)."""
        driven = np.array([wheel.driven for wheel in wheels], dtype=np.float64)
        self._drive_shares: Array = driven / max(driven.sum(), 1.0)
        self.speed: Array = np.atleast_1d(np.asarray(speed, dtype=np.float64)).copy()
        """Vehicle speed v [m/s], shape (n,)."""
        rolling = self.speed[:, np.newaxis] / self.radius if wheel_speed is None else wheel_speed
        shape = (*self.speed.shape, len(wheels))
        self.wheel_speed: Array = np.broadcast_to(np.asarray(rolling, dtype=np.float64), shape).copy()
        """Wheel speeds omega [rad/s], shape (n, 4)."""
        self.distance: Array = np.zeros_like(self.speed)
        """Distance covered [m], shape (n,)."""
        self.grade: ArrayLike = grade
        check_start(self.speed, self.wheel_speed, max_step)
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
        return np.asarray(self.acceleration(theta) + GRAVITY * np.sin(self.grade))

    def wheel_loads(self, theta: ArrayLike) -> Array:
        """Vertical loads [N] at the present acceleration, shape (n, 4)."""
        return wheel_loads(self.vehicle, self.acceleration(theta))

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
        """Advance by `dt` [s] under brake torques [N m] that change linearly, on the road `theta`.

        Brakes and rolling resistance only oppose rolling: a wheel stops at zero speed and stays there while they exceed
        friction and drive.

        Args:
            torque_begin: torque of each wheel at the start, >= 0, broadcasts to (n, 4).
            torque_end: torque of each wheel at the end, >= 0, broadcasts to (n, 4).
            theta: shape (3,), one road for all; (n, 3), one per car; or (n, 4, 3), one per wheel.
            dt: step [s], > 0.
            drive_torque: torque of the engine at all driven wheels together [N m], negative for engine braking,
                broadcasts to (n,); they share it equally (open differential). Ignored without a driven wheel.
        """
        steps, h = inner_steps(dt, self._max_step)
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
        drive = np.broadcast_to(np.asarray(drive_torque, dtype=np.float64), self.speed.shape)
        net -= self._drive_shares * drive[:, np.newaxis]
        return net

    @staticmethod
    def _reference(speed: Array) -> Array:
        return np.maximum(speed, SLIP_SPEED_FLOOR)[:, np.newaxis]

    def _slip(self, speed: Array, wheel_speed: Array) -> Array:
        return np.asarray((speed[:, np.newaxis] - wheel_speed * self.radius) / self._reference(speed))

    def _acceleration(self, speed: Array, friction: Array) -> Array:
        p = self.vehicle
        drag = 0.5 * AIR_DENSITY * p.drag_area / p.mass * speed**2
        return joint_acceleration(
            0.5 * (friction[:, 0] + friction[:, 1]),
            0.5 * (friction[:, 2] + friction[:, 3]),
            drag + GRAVITY * np.sin(self.grade),
            p.front_load_share,
            p.height_ratio,
            GRAVITY,
        )

    def _derivative(self, speed: Array, wheel_speed: Array, torque: Array, theta: Array) -> tuple[Array, Array]:
        slip = self._slip(speed, wheel_speed)
        acceleration, wheel_acceleration, _ = self._motion(speed, slip, torque, theta)
        return acceleration, wheel_acceleration

    def _motion(self, speed: Array, slip: Array, torque: Array, theta: Array) -> tuple[Array, Array, Array]:
        """Accelerations of body and wheels, and the loads of the wheels."""
        friction = burckhardt.friction(theta, slip)
        acceleration = self._acceleration(speed, friction)
        loads = wheel_loads(self.vehicle, acceleration)
        moment = self.radius * loads * (friction - self.vehicle.rolling_resistance)
        return acceleration, (moment - torque) / self.inertia, loads

    def _rosenbrock(self, torque: Array, torque_rate: Array, theta: Array, h: float) -> None:
        mass, radius, inertia = self.vehicle.mass, self.radius, self.inertia
        v, w = self.speed, self.wheel_speed
        reference = self._reference(v)
        slip = self._slip(v, w)
        f_v, f_w, loads = self._motion(v, slip, torque, theta)
        # Beyond the peak the true slope would make the implicit step divide by zero; any matrix keeps the second order.
        slope = loads * np.maximum(burckhardt.slope(theta, slip), 0.0)
        force_v = slope * np.where(v[:, np.newaxis] > SLIP_SPEED_FLOOR, w * radius / reference**2, 1.0 / reference)
        force_w = -slope * radius / reference
        # A locked wheel has no equation: left in, its pull below zero would reach the body through the matrix.
        turns = (w > 0.0) | (f_w >= 0.0)
        gh = GAMMA * h
        by_wheel = np.where(turns, gh * force_w / mass, 0.0)
        wheel_by_v = np.where(turns, -gh * radius * force_v / inertia, 0.0)
        wheel_own = 1.0 - np.where(turns, gh * radius * force_w / inertia, 0.0)
        body = 1.0 + gh * force_v.sum(axis=1) / mass - (by_wheel * wheel_by_v / wheel_own).sum(axis=1)

        def solve(b_v: Array, b_w: Array) -> tuple[Array, Array]:
            b_w = np.where(turns, b_w, 0.0)
            x_v = (b_v - (by_wheel * b_w / wheel_own).sum(axis=1)) / body
            return x_v, (b_w - wheel_by_v * x_v[:, np.newaxis]) / wheel_own

        def derivative_at_end(speed: Array, wheel_speed: Array) -> tuple[Array, Array]:
            return self._derivative(speed, wheel_speed, torque + h * torque_rate, theta)

        time_term = -gh * torque_rate / inertia
        speed, wheel_speed = two_stages((v, w), (f_v, f_w), time_term, h, solve, derivative_at_end)
        standing = (speed < REST_SPEED) & (speed <= v)
        self.speed = np.where(standing, 0.0, speed)
        self.wheel_speed = np.where(standing[:, np.newaxis], 0.0, np.maximum(wheel_speed, 0.0))


def _per_wheel(theta: ArrayLike) -> Array:
    """Road parameters that broadcast with slips of shape (n, 4)."""
    road = np.asarray(theta, dtype=np.float64)
    return road[:, np.newaxis, :] if road.ndim == 2 else road
