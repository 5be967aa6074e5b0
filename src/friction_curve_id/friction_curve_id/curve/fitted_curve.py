"""A fitted friction curve with the covariance of its parameters, and estimates at the peak and the present slip.

First-order error propagation. With s = d mu / d slip and p the parameters,
    d lambda_max = -(ds/dp at the peak) dp / (ds/dslip at the peak),   d mu_max = (dmu/dp at the peak) dp,
    P(slip beyond the peak) = P(s < 0 at the present slip), normal.
"""

from dataclasses import dataclass
from math import erf, isfinite, isnan, nan, sqrt
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.curve.validity import ValidityLimits
from friction_curve_id.interface import UNKNOWN_THETA_COVARIANCE, CurveEstimate

Array = NDArray[np.float64]


class CurveModel(Protocol):
    """A friction curve mu(slip; p) of n parameters."""

    def friction(self, parameters: Array, slip: float) -> float:
        """mu [-]."""
        ...

    def gradient(self, parameters: Array, slip: float) -> Array:
        """d mu / d p, shape (n,)."""
        ...

    def slope(self, parameters: Array, slip: float) -> float:
        """d mu / d slip [-]."""
        ...

    def slope_gradient(self, parameters: Array, slip: float) -> Array:
        """Gradient of the slope with respect to p, shape (n,)."""
        ...

    def curvature(self, parameters: Array, slip: float) -> float:
        """d^2 mu / d slip^2 [-]."""
        ...

    def peak(self, parameters: Array) -> float:
        """lambda_max in (0, 1), NaN where there is none."""
        ...

    def theta(self, parameters: Array) -> Array:
        """Burckhardt parameters, shape (3,), UNKNOWN_THETA for another model."""
        ...


@dataclass(frozen=True)
class FittedCurve:
    """Parameters and their covariance, shapes (n,) and (n, n); NaN covariance where it is unknown."""

    model: CurveModel
    parameters: Array
    covariance: Array

    def estimate(
        self,
        slip: float,
        samples: int,
        largest_slip: float,
        limits: ValidityLimits = ValidityLimits(),
    ) -> CurveEstimate:
        """Return the estimate at the present `slip`.

        Args:
            slip: present slip [-].
            samples: number of points in the fit.
            largest_slip: largest slip among them [-]; a peak beyond it is extrapolated, hence not valid.
            limits: limits within which the peak may be used.
        """
        m, p, covariance = self.model, self.parameters, self.covariance

        def stddev(row: Array) -> float:
            variance = float(row.dot(covariance).dot(row))  # less than `@` for a few parameters
            return sqrt(variance) if 0.0 <= variance < np.inf else nan

        peak = m.peak(p)
        mu_max = lambda_stddev = mu_stddev = nan
        if isfinite(peak):
            mu_max = m.friction(p, peak)
            mu_stddev = stddev(m.gradient(p, peak))
            curvature = m.curvature(p, peak)
            if curvature < 0.0:
                lambda_stddev = stddev(m.slope_gradient(p, peak)) / -curvature
        slope = m.slope(p, slip)
        slope_stddev = stddev(m.slope_gradient(p, slip))
        reason, text = limits.judge((0.0, largest_slip), peak, lambda_stddev)
        theta = m.theta(p)
        return CurveEstimate(
            samples=samples,
            slip=slip,
            lambda_max=peak,
            mu_max=mu_max,
            lambda_max_stddev=lambda_stddev,
            mu_max_stddev=mu_stddev,
            theta=theta.copy(),
            theta_covariance=UNKNOWN_THETA_COVARIANCE if isnan(theta[0]) else covariance,
            mu=m.friction(p, slip),
            slope=slope,
            slope_stddev=slope_stddev,
            probability_beyond_peak=probability_negative(slope, slope_stddev),
            reason=reason,
            text=text,
        )


def probability_negative(mean: float, stddev: float) -> float:
    """Probability that a normal variable is below zero, NaN where its standard deviation is."""
    if not isfinite(stddev):
        return nan
    if stddev == 0.0:
        return 1.0 if mean < 0.0 else 0.0
    return 0.5 * (1.0 + erf(-mean / (stddev * sqrt(2.0))))


def fit_covariance(rows: Array, residuals: Array) -> Array:
    """Covariance of an unweighted least-squares fit whose noise may be correlated between neighbours.

    Where neighbouring residuals are opposed (differenced signals share noise), the plain sigma^2 (X^T X)^-1 is too
    large. With T the tridiagonal Toeplitz matrix of the residuals' variance and lag-one covariance (limited to
    what a moving average of order one can have, hence T >= 0), the covariance is (X^T X)^-1 X^T T X (X^T X)^-1.
    Where they are alike (the model's error, oscillations), it is the plain one times `samples_per_information`.

    Args:
        rows: X, gradient of the curve at each sample, shape (samples, n).
        residuals: shape (samples,).

    Returns:
        Shape (n, n); NaN where there are no more samples than parameters.
    """
    samples, count = rows.shape
    if samples <= count:
        return np.full((count, count), np.nan)
    variance = float(residuals @ residuals) / (samples - count)
    lag = float(residuals[1:] @ residuals[:-1]) / (samples - count)
    inverse = gram_inverse(rows.T @ rows)
    if lag > 0.0:
        return variance * samples_per_information(residuals) * inverse
    neighbours = rows[1:].T @ rows[:-1]
    middle = variance * (rows.T @ rows) + max(lag, -0.5 * variance) * (neighbours + neighbours.T)
    return np.asarray(inverse @ middle @ inverse)


def samples_per_information(residuals: Array) -> float:
    """Samples that carry the information of one, >= 1: 1 + 2 sum of the autocorrelation.

    Summed are pairs of neighbouring lags as long as a pair is positive (initial positive sequence; Geyer 1992,
    Practical Markov Chain Monte Carlo): one lag at zero does not end it.

    Args:
        residuals: shape (n,).
    """
    centred = residuals - np.mean(residuals)
    power = float(centred @ centred)
    if power <= 0.0:
        return 1.0
    total = -1.0
    for lag in range(0, len(centred) // 4, 2):
        pair = float(centred[lag:] @ centred[: len(centred) - lag] + centred[lag + 1 :] @ centred[: -lag - 1]) / power
        if pair <= 0.0:
            break
        total += 2.0 * pair
    return max(total, 1.0)


def gram_inverse(gram: Array) -> Array:
    """Inverse of X^T X, shape (n, n), scaled diagonal floored by 1e-12: blind directions come out huge."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-18))
    scaled = gram / np.outer(scale, scale) + 1e-12 * np.eye(len(gram))
    return np.asarray(np.linalg.inv(scaled) / np.outer(scale, scale))
