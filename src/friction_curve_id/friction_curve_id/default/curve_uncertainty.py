"""From the fit in logarithmic coordinates to the published estimate, first-order error propagation.

lambda_max, mu_max and theta are positive and their logarithms nearly normal: standard deviations are those of the
logarithms times the values. The slip is beyond the peak where th2 slip > ln(th1 th2 / th3), both sides of which are
nearly linear in the unknowns (q, u, omega): the probability is that of this normal variable.
"""

from dataclasses import dataclass
from math import erf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.default.braking_window import NewestSlip
from friction_curve_id.interface import CurveEstimate, Reason, RestartCause
from vehicle_models import burckhardt_log

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ValidityLimits:
    """When lambda_max and mu_max may be used."""

    min_samples: int = 20
    max_relative_stddev: float = 0.1
    """Of lambda_max, > 0."""

    def judge(
        self, samples: int, slip_span: tuple[float, float], lambda_max: float, stddev: float
    ) -> tuple[Reason, str]:
        """Why the peak may not be used, OK if it may.

        Args:
            samples: in the fit.
            slip_span: smallest and largest slip in the fit [-].
            lambda_max: estimate [-], NaN for no peak.
            stddev: its standard deviation [-].
        """
        if samples < self.min_samples:
            return Reason.TOO_FEW_SAMPLES, f"{samples} of {self.min_samples} samples"
        if not isfinite(lambda_max):
            return Reason.NO_PEAK, "the fitted curve has no peak in (0, 1)"
        smallest, largest = slip_span
        if largest < lambda_max:
            text = f"slip has not passed the peak: it reached {largest:.3f}, the peak is expected at {lambda_max:.3f}"
            return Reason.PEAK_NOT_PASSED, text
        if smallest > lambda_max:
            return Reason.UNCERTAIN, f"all slips lie beyond the peak, from {smallest:.3f} on"
        if stddev > self.max_relative_stddev * lambda_max:
            return Reason.UNCERTAIN, f"lambda_max {lambda_max:.3f} has a standard deviation of {stddev:.3f}"
        return Reason.OK, ""


def describe(
    q: Array,
    covariance: Array,
    present: NewestSlip,
    samples: int,
    slip_span: tuple[float, float],
    limits: ValidityLimits,
    cause: RestartCause,
) -> CurveEstimate:
    """Say what the fit says; `covariance` is that of (q, u, omega), shape (5, 5)."""
    theta = burckhardt_log.to_theta(q)
    of_q = covariance[:3, :3]
    jacobian = burckhardt_log.theta_jacobian(theta)
    peak = burckhardt_log.peak(q)
    lambda_stddev = peak.lambda_max * sqrt(max(float(peak.lambda_gradient @ of_q @ peak.lambda_gradient), 0.0))
    mu_stddev = sqrt(max(float(peak.mu_gradient @ of_q @ peak.mu_gradient), 0.0))
    reason, text = limits.judge(samples, slip_span, peak.lambda_max, lambda_stddev)

    here = burckhardt_log.at(theta, present.slip)
    row = np.array([*here.slope_gradient, here.curvature * present.per_u, here.curvature * present.per_omega])
    th2 = float(theta[1])
    beyond_row = np.array([0.0, th2 * abs(present.slip) - 1.0, 1.0, th2 * present.per_u, th2 * present.per_omega])
    beyond = th2 * present.slip - burckhardt_log.peak_exponent(q)
    spread = sqrt(max(float(beyond_row @ covariance @ beyond_row), 1e-30))
    return CurveEstimate(
        samples=samples,
        slip=present.slip,
        lambda_max=peak.lambda_max,
        mu_max=peak.mu_max,
        lambda_max_stddev=lambda_stddev,
        mu_max_stddev=mu_stddev,
        theta=theta,
        theta_stddev=np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", jacobian, of_q, jacobian), 0.0)),
        mu=here.friction,
        slope=here.slope,
        slope_stddev=sqrt(max(float(row @ covariance @ row), 0.0)),
        probability_beyond_peak=0.5 * (1.0 + erf(beyond / (spread * sqrt(2.0)))),
        restarted=cause is not RestartCause.NONE,
        restart_cause=cause,
        valid=reason is Reason.OK,
        reason=reason,
        text=text,
    )
