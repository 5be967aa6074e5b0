"""The friction curve as four fixed exponentials, a line and a constant, (8.12); linear in its six parameters.

The chapter's exponents b = 4, 36, 68, 100 span th2 of the usual roads. The model does not hold the Burckhardt
curve of any road exactly: on the noise-free samples of manoeuvre B lambda_max is off by 3.5 % on dry, 0.5 % on
wet, 1.4 % on cobblestone and 0.2 % on snow, and this bias remains whatever the noise.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EXPONENTS = np.array([4.0, 36.0, 68.0, 100.0])
_GRID = np.concatenate([np.linspace(0.001, 0.2, 200), np.linspace(0.205, 1.0, 160)])
_GRID_DECAY = np.exp(-np.outer(_GRID, EXPONENTS))
_BISECTIONS = 40


def regressor(slips: Array) -> Array:
    """Regressor phi of (8.12), (exp(-b1 slip), ..., exp(-b4 slip), slip, 1) for slips of shape (n,), shape (n, 6)."""
    return np.concatenate([np.exp(-np.outer(slips, EXPONENTS)), slips[:, np.newaxis], np.ones((len(slips), 1))], axis=1)


class ExponentialCurve:
    """CurveModel of (8.12)."""

    def __init__(self, largest_slip: float) -> None:
        """Tell how far the data reach: a peak among them goes before one that is extrapolated."""
        self._largest_slip = largest_slip

    def friction(self, parameters: Array, slip: float) -> float:
        """Mu [-], (8.12)."""
        return float(self.gradient(parameters, slip) @ parameters)

    def gradient(self, parameters: Array, slip: float) -> Array:
        """phi, shape (6,)."""
        return np.array(regressor(np.array([slip]))[0])

    def slope(self, parameters: Array, slip: float) -> float:
        """D mu / d slip [-]."""
        return float(self.slope_gradient(parameters, slip) @ parameters)

    def slope_gradient(self, parameters: Array, slip: float) -> Array:
        """Gradient of the slope with respect to the parameters, shape (6,)."""
        return np.concatenate([-EXPONENTS * np.exp(-EXPONENTS * slip), [1.0, 0.0]])

    def curvature(self, parameters: Array, slip: float) -> float:
        """d^2 mu / d slip^2 [-]."""
        return float((EXPONENTS**2 * np.exp(-EXPONENTS * slip)) @ parameters[:4])

    def peak(self, parameters: Array) -> float:
        """lambda_max in (0, 1): the highest maximum among the data, else the first beyond them; NaN without any.

        The slope is a sum of exponentials with at most four zeros. Its changes of sign from + to - on a grid
        finer than 1 / b are bracketed and bisected.
        """
        slopes = parameters[4] - _GRID_DECAY @ (EXPONENTS * parameters[:4])
        falls = np.flatnonzero((slopes[:-1] > 0.0) & (slopes[1:] <= 0.0))
        maxima = [self._bisect(parameters, _GRID[k], _GRID[k + 1]) for k in falls]
        among = [peak for peak in maxima if peak <= self._largest_slip]
        if among:
            return max(among, key=lambda peak: self.friction(parameters, peak))
        return maxima[0] if maxima else float("nan")

    def theta(self, parameters: Array) -> Array | None:
        """None: (8.12) is not a Burckhardt curve."""
        return None

    def _bisect(self, parameters: Array, low: float, high: float) -> float:
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if self.slope(parameters, middle) > 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
