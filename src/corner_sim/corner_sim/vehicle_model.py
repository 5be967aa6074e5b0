"""Interface of a vehicle model of the plant, and the model made of single corners."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corner_sim.corner import SingleCorner
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]


class VehicleModel(Protocol):
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
        """Advance by dt [s] under brake torques [N m] that change linearly."""


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
