"""The friction curve as four fixed exponentials, a line and a constant, (8.12); linear in its six parameters.

The chapter's exponents b = 4, 36, 68, 100 span th2 of the usual roads. The model does not hold the Burckhardt
curve of any road exactly: on the noise-free samples of manoeuvre B lambda_max is off by 3.5 % on dry, 0.5 % on
wet, 1.4 % on cobblestone and 0.2 % on snow, and this bias remains whatever the noise.
"""

from math import exp, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.interface import UNKNOWN_THETA

Array = NDArray[np.float64]

EXPONENTS = np.array([4.0, 36.0, 68.0, 100.0])
_RATES = np.append(-EXPONENTS, [0.0, 0.0])
"""Growth rates of all six terms; 0 for the line and the constant."""
_PLAIN_EXPONENTS: Final[list[float]] = EXPONENTS.tolist()
_GRID: Final[list[float]] = np.concatenate([np.linspace(0.001, 0.2, 200), np.linspace(0.205, 1.0, 160)]).tolist()
_STEPS: Final = 40
_CONVERGED: Final = 1e-12
"""Step [-] that ends the search for a peak: a further one would be rounding."""


def regressor(slips: Array) -> Array:
    """Regressor phi of (8.12), (exp(-b1 slip), ..., exp(-b4 slip), slip, 1) for slips of shape (n,), shape (n, 6)."""
    rows = np.asarray(np.exp(np.outer(slips, _RATES)))
    rows[:, 4] = slips
    return rows


def regressor_row(slip: float) -> Array:
    """Regressor phi of one slip, shape (6,)."""
    return np.array([*[exp(-exponent * slip) for exponent in _PLAIN_EXPONENTS], slip, 1.0])


def slope_row(slip: float) -> Array:
    """d phi / d slip, shape (6,)."""
    return np.array([*[-exponent * exp(-exponent * slip) for exponent in _PLAIN_EXPONENTS], 1.0, 0.0])


_GRID_SLOPES = np.array([slope_row(slip) for slip in _GRID])


class ExponentialCurve:
    """CurveModel of (8.12); in plain floats, as for four terms numpy takes several times as long."""

    def __init__(self, largest_slip: float) -> None:
        """Set how far the data reach [-]: a peak among them is preferred to one that is extrapolated."""
        self._largest_slip = largest_slip

    def friction(self, parameters: Array, slip: float) -> float:
        """mu [-], (8.12)."""
        plain: list[float] = parameters.tolist()
        friction = plain[4] * slip + plain[5]
        for term, exponent in enumerate(_PLAIN_EXPONENTS):
            friction += plain[term] * exp(-exponent * slip)
        return friction

    def gradient(self, parameters: Array, slip: float) -> Array:
        """phi, shape (6,)."""
        return regressor_row(slip)

    def slope(self, parameters: Array, slip: float) -> float:
        """d mu / d slip [-]."""
        return _slope_and_curvature(parameters.tolist(), slip)[0]

    def slope_gradient(self, parameters: Array, slip: float) -> Array:
        """Gradient of the slope with respect to the parameters, shape (6,)."""
        return slope_row(slip)

    def curvature(self, parameters: Array, slip: float) -> float:
        """d^2 mu / d slip^2 [-]."""
        return _slope_and_curvature(parameters.tolist(), slip)[1]

    def peak(self, parameters: Array) -> float:
        """lambda_max in (0, 1): the highest maximum among the data, else the first beyond them; NaN without any.

        The slope is a sum of exponentials with at most four zeros. Its changes of sign from + to - on a grid
        finer than 1 / b are bracketed, and found there by Newton's method.
        """
        slopes = _GRID_SLOPES.dot(parameters)
        rises = slopes > 0.0
        falls = (rises[:-1] > rises[1:]).nonzero()[0].tolist()
        maxima = [_zero_of_slope(parameters.tolist(), _GRID[k], _GRID[k + 1]) for k in falls]
        among = [peak for peak in maxima if peak <= self._largest_slip]
        if len(among) > 1:
            return max(among, key=lambda peak: self.friction(parameters, peak))
        return next(iter(among or maxima), nan)

    def theta(self, parameters: Array) -> Array:
        """Return UNKNOWN_THETA: (8.12) is not a Burckhardt curve."""
        return UNKNOWN_THETA


def _slope_and_curvature(parameters: list[float], slip: float) -> tuple[float, float]:
    slope, curvature = parameters[4], 0.0
    for term, exponent in enumerate(_PLAIN_EXPONENTS):
        fall = exponent * parameters[term] * exp(-exponent * slip)
        slope -= fall
        curvature += exponent * fall
    return slope, curvature


def _zero_of_slope(parameters: list[float], low: float, high: float) -> float:
    """Return the slip between two at which the slope falls through zero: Newton's method, or bisection if it leaves."""
    slip = 0.5 * (low + high)
    for _ in range(_STEPS):
        slope, curvature = _slope_and_curvature(parameters, slip)
        if slope > 0.0:
            low = slip
        else:
            high = slip
        last, slip = slip, slip - slope / curvature if curvature < 0.0 else nan
        if not low <= slip <= high:
            slip = 0.5 * (low + high)
        if abs(slip - last) <= _CONVERGED:
            break
    return slip
