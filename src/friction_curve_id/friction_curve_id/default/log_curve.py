"""The Burckhardt curve (2.13) in logarithmic coordinates q = (ln th1, ln th2, ln(th3 / th1)), shape (3,).

Every q is a tyre (all parameters positive), equal steps are equal percentages, and the third coordinate is the one the
published roads agree about. Gradients are with respect to q.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def to_theta(q: Array) -> Array:
    """(th1, th2, th3), shape (3,)."""
    th1, th2, ratio = np.exp(q)
    return np.array([th1, th2, ratio * th1])


def from_theta(theta: Array) -> Array:
    """Inverse of `to_theta`; theta > 0."""
    return np.asarray(np.log([theta[0], theta[1], theta[2] / theta[0]]))


def theta_jacobian(q: Array) -> Array:
    """D theta / d q, shape (3, 3)."""
    th1, th2, th3 = to_theta(q)
    return np.array([[th1, 0.0, 0.0], [0.0, th2, 0.0], [th3, 0.0, th3]])


def friction_into(q: Array, slip: Array, gradient: Array) -> tuple[Array, Array]:
    """Mu and d mu / d slip at `slip`, shapes (n,); writes d mu / d q into `gradient`, shape (n, 3).

    Odd in slip, like `vehicle_models.burckhardt`.
    """
    th1, th2, th3 = to_theta(q)
    decay = np.exp(-th2 * np.abs(slip))
    mu = np.copysign(th1 * (1.0 - decay), slip) - th3 * slip
    steep = (th1 * th2) * decay
    gradient[:, 0] = mu
    np.multiply(steep, slip, out=gradient[:, 1])
    np.multiply(slip, -th3, out=gradient[:, 2])
    return mu, steep - th3


@dataclass(frozen=True)
class Peak:
    """Peak of a curve; NaN where it has none in (0, 1)."""

    lambda_max: float
    mu_max: float
    lambda_gradient: Array
    """D ln(lambda_max) / d q, shape (3,)."""
    mu_gradient: Array
    """D mu_max / d q, shape (3,)."""


def peak(q: Array) -> Peak:
    """Peak in closed form: lambda_max = l / th2 with l = ln(th1 th2 / th3), where the slope vanishes."""
    th1, th2, th3 = to_theta(q)
    log_ratio = float(q[1] - q[2])
    lambda_max = log_ratio / th2
    if not 0.0 < lambda_max < 1.0:
        nothing = np.full(3, np.nan)
        return Peak(np.nan, np.nan, nothing, nothing)
    mu_max = th1 - th3 / th2 * (1.0 + log_ratio)
    return Peak(
        lambda_max,
        mu_max,
        np.array([0.0, 1.0 / log_ratio - 1.0, -1.0 / log_ratio]),
        np.array([mu_max, th3 * lambda_max, -th3 * lambda_max]),
    )
