"""The single corner linearised at a slip, (8.1) and (8.2): response of slip and wheel deceleration to the brake.

With the speed v taken for a slowly varying parameter, eta = -r omega_dot / g and mu_1 the slope (2.37) of the curve:

    G_lambda(s) = (r / (J v)) / (s - p),    G_eta(s) = (r / (J g)) (s + (mu_1 Fz / (m v)) (1 - lambda)) / (s - p),
    p = -(mu_1 Fz / (m v)) (1 - lambda + m r^2 / J)

A slow speed also means that (8.1) leaves out of p what the relative change of speed v_dot / v adds to it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import burckhardt
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]
TransferFunction = tuple[Array, Array]
"""Coefficients of numerator and denominator, highest power of s first."""


def pole(corner: CornerParameters, theta: ArrayLike, slip: float, speed: float) -> float:
    """Pole p of (8.1) and (8.2) [1/s].

    Args:
        corner: the wheel.
        theta: Burckhardt parameters of the road, shape (3,).
        slip: lambda [-].
        speed: v [m/s], > 0.

    Raises:
        ValueError: the speed is not positive.
    """
    wheel = corner.mass * corner.radius**2 / corner.inertia
    return -_slope_term(corner, theta, slip, speed) * (1.0 - slip + wheel)


def slip_transfer(corner: CornerParameters, theta: ArrayLike, slip: float, speed: float) -> TransferFunction:
    """G_lambda(s), (8.1), from brake torque [N m] to slip [-]; arguments as for `pole`."""
    denominator = np.array([1.0, -pole(corner, theta, slip, speed)])
    return np.array([corner.radius / (corner.inertia * speed)]), denominator


def deceleration_transfer(corner: CornerParameters, theta: ArrayLike, slip: float, speed: float) -> TransferFunction:
    """G_eta(s), (8.2), from brake torque [N m] to normalised wheel deceleration [-]; arguments as for `pole`."""
    gain = corner.radius / (corner.inertia * corner.gravity)
    zero = -_slope_term(corner, theta, slip, speed) * (1.0 - slip)
    return gain * np.array([1.0, -zero]), np.array([1.0, -pole(corner, theta, slip, speed)])


def is_stable(theta: ArrayLike, slip: ArrayLike) -> NDArray[np.bool_]:
    """Whether the pole of (8.1) and (8.2) is negative: whatever speed, load and wheel, where mu_1 > 0."""
    return np.asarray(burckhardt.slope(theta, slip) > 0.0)


def _slope_term(corner: CornerParameters, theta: ArrayLike, slip: float, speed: float) -> float:
    """mu_1 Fz / (m v) [1/s]"""
    if not speed > 0.0:
        raise ValueError(f"speed must be > 0, is {speed}")
    return float(burckhardt.slope(theta, slip)) * corner.vertical_load / (corner.mass * speed)
