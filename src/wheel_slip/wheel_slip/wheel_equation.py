"""Speed of the rim of every wheel by the states of the car: the wheel rolls, slides, is released or locked alike.

A wheel at (x_i, y_i) from the middle of the rear axle rolls on ground that passes at

    g_i = v - u y_i + (u x_i)^2 / 2v,    z_i + (sigma_i / v)(v' - r omega_i') = g_i (1 - c_i d_i)(1 - e_i) + n_i

in which the left side is the rim speed, ahead of the tyre by the relaxation length sigma_i, and d_i is g times the
force of the tyre over its load (tyre_forces.py); v, u, c and e are states of car_motion.py.
"""

from math import isfinite

import numpy as np
from numpy.typing import NDArray

from vehicle_models.vehicle import FRONT, Vehicle

Array = NDArray[np.float64]

V, B, K, U, T, F, S, C = range(8)
"""Indices of the states; those of c begin at C, those of e follow."""
SLOWEST_TURN = 3.0
"""Speed [m/s] that divides in place of a slower one where a curve is told by it: a car can turn on the spot."""


def speed_before(x: Array, age: float, way: float) -> tuple[Array, Array]:
    """Return the speed of the car some time before states [m/s], and its derivatives by them.

    Args:
        x: states, shape (..., states).
        age: how long before [s].
        way: integral of the accelerometer's readings since then [m/s].
    """
    h = np.zeros_like(x)
    since, kept = way - age * x[..., B], 1.0 - x[..., K]
    h[..., V], h[..., B], h[..., K] = 1.0, age * kept, since
    return x[..., V] - since * kept, h


class WheelEquation:
    """Of the wheels of one car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take where the wheels are."""
        wheels = vehicle.wheels
        self._left = np.array([0.5 * vehicle.track * (1.0 if wheel.side == "left" else -1.0) for wheel in wheels])
        self._ahead = np.array([0.5 * vehicle.wheelbase**2 if wheel.axle == FRONT else 0.0 for wheel in wheels])
        self._wheels = np.arange(len(wheels))

    def ground(self, speed: Array, yaw_rate: Array) -> tuple[Array, Array]:
        """Return the ground speed of every wheel [m/s] and its change with the yaw rate [m], in the last axis."""
        bend = self._ahead * yaw_rate / np.maximum(np.abs(speed), SLOWEST_TURN)
        return speed + (bend - self._left) * yaw_rate, 2.0 * bend - self._left

    def turn(self, rim_speeds: Array) -> float:
        """Return the yaw rate at which the wheels roll [rad/s], 0 where those of one side are missing."""
        left, right = rim_speeds[self._left > 0.0], rim_speeds[self._left < 0.0]
        if not left.size or not right.size:
            return 0.0
        found = float((np.mean(right) - np.mean(left)) / (2.0 * self._left.max()))
        return found if isfinite(found) else 0.0

    def expected(self, speed: Array, by_states: Array, x: Array, force: Array, by_engine: Array) -> tuple[Array, Array]:
        """Return rim speeds [m/s], and their derivatives by the states, shape (hypotheses, wheels, states).

        Args:
            speed: of the car at their time, by each hypothesis [m/s], shape (hypotheses,).
            by_states: derivatives of it by the states, shape (hypotheses, states).
            x: states, shape (hypotheses, states).
            force: of the tyres over their loads, times g [m/s^2], shape (hypotheses, wheels).
            by_engine: change of it with f [-], shape (hypotheses, wheels).
        """
        wheels, count = self._wheels, self._wheels.size
        compliance, of_radius = x[:, C : C + count], 1.0 - x[:, C + count :]
        roll = (1.0 - compliance * force) * of_radius
        ground, by_yaw = self.ground(speed[:, None], x[:, U, None])
        h = roll[:, :, None] * by_states[:, None, :]
        h[:, :, U] = roll * by_yaw
        h[:, :, F] = -ground * compliance * by_engine * of_radius
        h[:, wheels, C + wheels] = -ground * force * of_radius
        h[:, wheels, C + count + wheels] = -ground * roll
        return ground * roll, h
