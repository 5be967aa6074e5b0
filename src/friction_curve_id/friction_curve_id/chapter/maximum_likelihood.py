"""Batch maximum likelihood (8.10) of the Burckhardt parameters, with the initialisation (8.11).

With white noise of equal variance on mu the likelihood is the sum of squares (8.9). (8.10) is its Gauss-Newton step.

Two things are not as printed:
- (8.11) lacks a factor 1/2. The expansion of (2.13) is mu = (th1 th2 - th3) slip - (1/2) th1 th2^2 slip^2.
- the step is damped (Levenberg-Marquardt): H + d diag(H) in place of H in (8.10), d falling tenfold on a step
  that lowers (8.9) and rising tenfold on one that does not (which is not taken). Near the optimum d vanishes
  and the step is (8.10). Undamped, (8.10) leaves the box of sensible curves, or never settles, in every run on
  snow, and in a fifth of those on dry and wet asphalt while only 50 samples are there: xi is nearly collinear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.chapter.sample_window import SampleWindow
from friction_curve_id.curve.burckhardt_curve import THETA_HIGH, THETA_LOW, BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve, fit_covariance
from vehicle_models import burckhardt

Array = NDArray[np.float64]

INITIAL_THETA_3 = 0.4
"""theta_3(0) of the chapter: the mean over Table 8.1."""
_USUAL_STEEPNESS, _STEEPNESS_SPREAD = 30.0, 6.0
"""th2(0) where the first samples do not bend enough to determine it: with so few and small slips the error of the
quadratic term of (8.11) is larger than the term itself."""
_FRICTION_NOISE = 0.02
"""Noise of mu [-] that weighs this prior of th2 against the samples."""
_MAX_ITERATIONS = 60
_MIN_DAMPING, _MAX_DAMPING = 1e-10, 1e8
_CONVERGED = 1e-9


def initial_theta(slips: Array, frictions: Array) -> Array:
    """theta(0), shape (3,), from samples at low slip by (8.11) with its missing 1/2 and th3(0) = 0.4.

    The quadratic is interpolated by least squares in a = th1 th2 and b = th1 th2^2, with one weak further line that
    draws b / a = th2 to 30 +- 6. th1 then follows from the curve itself at that th2.

    Args:
        slips: shape (n,), n >= 2, not all zero.
        frictions: mu at them, shape (n,).
    """
    raised = frictions + INITIAL_THETA_3 * slips
    rows = np.stack([slips, -0.5 * slips * np.abs(slips)], axis=-1)
    gain = max(float(slips @ raised) / max(float(slips @ slips), 1e-12), 0.1)
    weight = _FRICTION_NOISE / (gain * _STEEPNESS_SPREAD)
    rows = np.vstack([rows, [-_USUAL_STEEPNESS * weight, weight]])
    a, b = np.linalg.lstsq(rows, np.append(raised, 0.0), rcond=None)[0]
    th2 = float(np.clip(b / a, 4.0, 100.0)) if a > 0.0 else _USUAL_STEEPNESS
    shape = burckhardt.friction(np.array([1.0, th2, 0.0]), slips)
    th1 = float(shape @ raised) / max(float(shape @ shape), 1e-12)
    return np.array([np.clip(th1, 0.05, 2.0), th2, INITIAL_THETA_3])


@dataclass(frozen=True)
class BatchFit:
    """Result of `fit`."""

    theta: Array
    """Shape (3,)."""
    covariance: Array
    """Shape (3, 3)."""
    iterations: int
    """Steps tried."""


def fit(slips: Array, frictions: Array, theta_0: Array) -> BatchFit:
    """Minimise (8.9) by damped steps (8.10) from theta_0.

    Args:
        slips: shape (n,), n >= 3.
        frictions: mu at them, shape (n,).
        theta_0: start, shape (3,); it is moved into the box of sensible curves.
    """
    theta = np.clip(theta_0, THETA_LOW, THETA_HIGH)
    residuals = frictions - burckhardt.friction(theta, slips)
    cost, damping, iterations = float(residuals @ residuals), 1e-3, 0
    rows = burckhardt.gradient(theta, slips)
    while iterations < _MAX_ITERATIONS and damping < _MAX_DAMPING:
        iterations += 1
        gram = rows.T @ rows
        diagonal = np.maximum(np.diag(gram), 1e-9)
        step = np.linalg.solve(gram + np.diag(damping * diagonal), rows.T @ residuals)
        trial = np.clip(theta + step, THETA_LOW, THETA_HIGH)
        trial_residuals = frictions - burckhardt.friction(trial, slips)
        trial_cost = float(trial_residuals @ trial_residuals)
        if not trial_cost < cost:
            damping *= 10.0
            continue
        gained = cost - trial_cost
        theta, residuals, cost, damping = trial, trial_residuals, trial_cost, max(damping / 10.0, _MIN_DAMPING)
        rows = burckhardt.gradient(theta, slips)
        if gained <= _CONVERGED * cost:
            break
    return BatchFit(theta, fit_covariance(rows, residuals), iterations)


class MaximumLikelihood(SampleWindow):
    """Batch ML over the newest samples: a fit from scratch at every sample."""

    def curve(self) -> FittedCurve:
        """Fit the curve."""
        slips, frictions = self.samples()
        result = fit(slips, frictions, initial_theta(slips[:20], frictions[:20]))
        return FittedCurve(BurckhardtCurve(), result.theta, result.covariance)
