"""What the plant asks of a vehicle model, and the model made of equal corners."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vehicle_models.single_corner import CornerParameters, SingleCorner

Array = NDArray[np.float64]


class Vehicle(Protocol):
    """A vehicle with n braked wheels; arrays have shape (n,), theta has shape (n, 3)."""

    @property
    def speed(self) -> float:
        """Vehicle speed v [m/s], >= 0."""

    @property
    def distance(self) -> Array:
        """Distance covered by each wheel [m]."""

    @property
    def wheel_speed(self) -> Array:
        """Wheel speed omega [rad/s], >= 0."""

    @property
    def slip(self) -> Array:
        """Slip lambda [-], braking positive."""

    @property
    def radius(self) -> Array:
        """Effective rolling radius r [m]."""

    @property
    def inertia(self) -> Array:
        """Wheel inertia J [kg m^2]."""

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds the first wheel at the peak of the road theta, shape (3,)."""

    def vertical_load(self, theta: Array) -> Array:
        """Load Fz of each wheel [N]."""

    def acceleration(self, theta: Array) -> float:
        """Vehicle acceleration [m/s^2], negative in braking."""

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel acceleration [rad/s^2]."""

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance by dt [s] under brake torques [N m] that run linearly."""


class JoinedCorners:
    """Equal corners, (2.15), that carry one body: they share its speed and do not shift load.

    The corners are integrated each on its own over a sample; then the body takes the mean of their speeds, which
    conserves momentum (the masses are equal). One corner alone is exactly the single-corner model.
    """

    def __init__(self, count: int, parameters: CornerParameters, speed: float) -> None:
        """Start `count` corners free rolling at `speed` [m/s]."""
        self._corners = SingleCorner(parameters, np.full(count, speed))
        self._parameters = parameters

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
        return np.full_like(self.wheel_speed, self._parameters.radius)

    @property
    def inertia(self) -> Array:
        """Wheel inertias [kg m^2], shape (n,)."""
        return np.full_like(self.wheel_speed, self._parameters.inertia)

    def peak_torque(self, theta: Array) -> float:
        """Brake torque [N m] that holds a wheel at the peak of the road theta, shape (3,)."""
        return float(self._parameters.peak_torque(theta))

    def vertical_load(self, theta: Array) -> Array:
        """Loads [N], shape (n,)."""
        return np.full_like(self.wheel_speed, self._parameters.vertical_load)

    def acceleration(self, theta: Array) -> float:
        """Acceleration of the body [m/s^2]."""
        return float(self._corners.acceleration(theta).mean())

    def wheel_acceleration(self, theta: Array, brake_torque: Array) -> Array:
        """Wheel accelerations [rad/s^2], shape (n,)."""
        return self._corners.wheel_acceleration(theta, brake_torque)

    def step(self, torque_begin: Array, torque_end: Array, theta: Array, dt: float) -> None:
        """Advance all corners by dt [s] and join them again."""
        corners = self._corners
        corners.step(torque_begin, torque_end, theta, dt)
        if corners.speed.size > 1:
            corners.speed = np.full_like(corners.speed, corners.speed.mean())
            corners.distance = np.full_like(corners.distance, corners.distance.mean())
