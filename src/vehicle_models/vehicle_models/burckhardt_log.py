"""The Burckhardt curve (2.13) in logarithmic coordinates q = (ln th1, ln th2, ln(th3 / th1)), shape (3,).

Every q is a tyre (all parameters positive), equal steps are equal percentages, and the third coordinate is the one the
published roads agree about. Gradients are with respect to q. The curve itself is that of `burckhardt`, its value here
as th1 (1 - exp(-th2 slip)): value and slope share the exponential.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vehicle_models import burckhardt

Array = NDArray[np.float64]


def to_theta(q: Array) -> Array:
    """(th1, th2, th3), shape (3,)."""
    th1, th2, ratio = np.exp(q)
    return np.array([th1, th2, ratio * th1])


def theta_jacobian(theta: Array) -> Array:
    """d theta / d q at `theta`, shape (..., 3); returns shape (..., 3, 3)."""
    jacobian = np.zeros((*theta.shape, 3))
    jacobian[..., 0, 0] = theta[..., 0]
    jacobian[..., 1, 1] = theta[..., 1]
    jacobian[..., 2, 0] = jacobian[..., 2, 2] = theta[..., 2]
    return jacobian


def steepness(q: Array) -> float:
    """th1 th2, the slope at slip 0 without the fall-off th3."""
    return float(np.exp(q[0] + q[1]))


def friction_into(q: Array, slip: Array | float, gradient: Array) -> tuple[Array, Array]:
    """Return mu and d mu / d slip at `slip`; write d mu / d q into `gradient`. Odd in slip, like `burckhardt`.

    Args:
        q: coordinates of the curve, shape (3,).
        slip: slip [-], shape (n,), or one number.
        gradient: output, shape (n, 3), or (3,).
    """
    th1, th2, th3 = to_theta(q)
    decay = np.exp(-th2 * np.abs(slip))
    mu = np.copysign(th1 * (1.0 - decay), slip) - th3 * slip
    steep = (th1 * th2) * decay
    gradient[..., 0] = mu
    np.multiply(steep, slip, out=gradient[..., 1])
    np.multiply(slip, -th3, out=gradient[..., 2])
    return mu, steep - th3


@dataclass(frozen=True)
class Point:
    """The curve at one slip."""

    friction: float
    """mu [-], odd in slip."""
    slope: float
    """d mu / d slip [-]."""
    slope_gradient: Array
    """Gradient of the slope with respect to q, shape (3,)."""
    curvature: float
    """Change of the slope with the magnitude of the slip [-]."""


def at(theta: Array, slip: float) -> Point:
    """Evaluate the curve of `theta`, shape (3,), at one slip."""
    th1, th2, th3 = (float(value) for value in theta)
    magnitude = abs(slip)
    steep = th1 * th2 * float(np.exp(-th2 * magnitude))
    slope = steep - th3
    return Point(
        friction=float(np.copysign(th1 - steep / th2, slip) - th3 * slip),
        slope=slope,
        slope_gradient=np.array([slope, steep * (1.0 - th2 * magnitude), -th3]),
        curvature=-steep * th2,
    )


@dataclass(frozen=True)
class Peak:
    """Peak of a curve; NaN where it has none in (0, 1)."""

    lambda_max: float
    mu_max: float
    lambda_gradient: Array
    """d ln(lambda_max) / d q, shape (3,)."""
    mu_gradient: Array
    """d mu_max / d q, shape (3,)."""


def peak_exponent(q: Array) -> float:
    """Decay th2 lambda_max = ln(th1 th2 / th3) at the peak [-], as `burckhardt.peak_exponent`."""
    return float(q[1] - q[2])


def lambda_max(q: Array) -> float:
    """Slip at which the slope vanishes [-], not necessarily in (0, 1)."""
    return peak_exponent(q) / float(np.exp(q[1]))


def peak(q: Array) -> Peak:
    """Peak in closed form."""
    slip = lambda_max(q)
    if not 0.0 < slip < 1.0:
        nothing = np.full(3, np.nan)
        return Peak(np.nan, np.nan, nothing, nothing)
    theta = to_theta(q)
    exponent = peak_exponent(q)
    mu_max = float(burckhardt.friction_at_peak(theta, exponent))
    fall = theta[2] * slip
    return Peak(slip, mu_max, lambda_gradient(exponent), np.array([mu_max, fall, -fall]))


def lambda_gradient(exponent: Array | float) -> Array:
    """d ln(lambda_max) / d q from the decay at the peak, shape (3,), or (3, n) from n of them."""
    return np.array([0.0 * exponent, 1.0 / exponent - 1.0, -1.0 / exponent])
