"""RML as the chapter describes it: the recursion of least squares in its covariance form, on the step (8.10).

    K = P xi / (1 + xi^T P xi),    theta += K epsilon,    P -= K xi^T P

in theta itself, without extra gain. `friction_curve_id` ships another form, which cannot diverge; this one is here to
show which of the chapter's numbers it gives.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.chapter.maximum_likelihood import initial_theta
from friction_curve_id.curve.burckhardt_curve import THETA_HIGH, THETA_LOW, BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve
from vehicle_models import burckhardt

Array = NDArray[np.float64]


class CovarianceRML:
    """RML of section 8.3.1.1 in covariance form; a CurveFit."""

    def __init__(self, covariance: float = 1.0) -> None:
        """Start P at `covariance` times the unit matrix: the chapter names no other."""
        self._covariance = covariance
        self._theta, self._p = np.zeros(3), np.eye(3)

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with theta(0) by (8.11) from the first samples, shapes (n,)."""
        self._theta = initial_theta(slips, frictions)
        self._p = self._covariance * np.eye(3)

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        xi = burckhardt.gradient(self._theta, slip)
        gain = self._p @ xi / (1.0 + float(xi @ self._p @ xi))
        error = friction - float(burckhardt.friction(self._theta, slip))
        self._theta = np.clip(self._theta + gain * error, THETA_LOW, THETA_HIGH)
        self._p = self._p - np.outer(gain, xi @ self._p)

    def curve(self) -> FittedCurve:
        """The curve so far; the chapter gives no deviation."""
        return FittedCurve(BurckhardtCurve(), self._theta, np.full((3, 3), np.nan))
