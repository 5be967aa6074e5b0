"""The Burckhardt curve (2.13) as a model to fit, theta = (th1, th2, th3)."""

from math import copysign, exp, expm1, log, nan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

THETA_LOW = np.array([0.02, 1.0, -5.0])
THETA_HIGH = np.array([5.0, 300.0, 5.0])
"""No fit leaves this box: wide enough for racing tyres (2.33, 23.4, 3.79) and snow (0.19, 94.13, 0.06). th3 < 0 is a
curve without a peak, the honest fit of data that end before it."""

UNKNOWNS_LOW = np.array([np.log(0.02), np.log(1.0), 1e-3])
UNKNOWNS_HIGH = np.array([np.log(5.0), np.log(300.0), 5.0])
"""The same box for fits in (ln th1, ln th2, th3), which do not end before the peak."""


def to_theta(unknowns: Array) -> Array:
    """theta from (ln th1, ln th2, th3), both of shape (3,)."""
    return np.array([np.exp(unknowns[0]), np.exp(unknowns[1]), unknowns[2]])


def to_unknowns(theta: Array) -> Array:
    """(ln th1, ln th2, th3) from theta, both of shape (3,)."""
    return np.array([np.log(theta[0]), np.log(theta[1]), theta[2]])


def theta_per_unknown(theta: Array) -> Array:
    """d theta / d (ln th1, ln th2, th3), which is diagonal: shape (3,)."""
    return np.array([theta[0], theta[1], 1.0])


class BurckhardtCurve:
    """CurveModel of (2.13): vehicle_models.burckhardt for one curve and one slip, in floats.

    An estimate asks for eight of these at every sample: with arrays of no dimension that took a sixth of the graph.
    """

    def friction(self, parameters: Array, slip: float) -> float:
        """mu [-], (2.13)."""
        th1, th2, th3 = parameters.tolist()
        magnitude = abs(slip)
        return copysign(1.0, slip) * (-th1 * expm1(-th2 * magnitude) - th3 * magnitude)

    def gradient(self, parameters: Array, slip: float) -> Array:
        """xi of (8.10), shape (3,)."""
        th1, th2, _ = parameters.tolist()
        magnitude = abs(slip)
        decay = exp(-th2 * magnitude)
        sign = copysign(1.0, slip)
        return np.array([sign * (1.0 - decay), sign * th1 * magnitude * decay, -slip])

    def slope(self, parameters: Array, slip: float) -> float:
        """d mu / d slip [-], (2.37)."""
        th1, th2, th3 = parameters.tolist()
        return float(th1 * th2 * exp(-th2 * abs(slip)) - th3)

    def slope_gradient(self, parameters: Array, slip: float) -> Array:
        """Gradient of the slope with respect to theta, shape (3,)."""
        th1, th2, _ = parameters.tolist()
        magnitude = abs(slip)
        decay = exp(-th2 * magnitude)
        return np.array([th2 * decay, th1 * decay * (1.0 - th2 * magnitude), -1.0])

    def curvature(self, parameters: Array, slip: float) -> float:
        """d^2 mu / d slip^2 [-] at slip >= 0."""
        th1, th2, _ = parameters.tolist()
        return float(-th1 * th2**2 * exp(-th2 * slip))

    def peak(self, parameters: Array) -> float:
        """lambda_max in closed form where it lies in (0, 1), else NaN."""
        th1, th2, th3 = parameters.tolist()
        if not (th1 > 0.0 and th2 > 0.0 and th1 * th2 > th3 > 0.0):
            return nan
        peak = log(th1 * th2 / th3) / th2
        return peak if 0.0 < peak < 1.0 else nan

    def theta(self, parameters: Array) -> Array:
        """The parameters themselves, shape (3,)."""
        return parameters
