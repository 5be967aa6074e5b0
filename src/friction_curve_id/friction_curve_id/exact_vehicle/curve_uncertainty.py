"""From the fit in logarithmic coordinates to the published estimate, first-order error propagation.

lambda_max, mu_max and theta are positive and their logarithms nearly normal: standard deviations are those of the
logarithms times the values. The slip is beyond the peak where th2 slip > ln(th1 th2 / th3), both sides of which are
nearly linear in the unknowns (q, u, omega): the probability is that of this normal variable.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.curve.fitted_curve import probability_negative
from friction_curve_id.curve.validity import ValidityLimits
from friction_curve_id.exact_vehicle.braking_window import NewestSlip
from friction_curve_id.interface import CurveEstimate, RestartCause
from vehicle_models import burckhardt_log
from vehicle_models.reason import Reason

Array = NDArray[np.float64]


def describe(
    q: Array,
    covariance: Array,
    present: NewestSlip,
    samples: int,
    slip_span: tuple[float, float],
    began_beyond: bool,
    limits: ValidityLimits,
    cause: RestartCause,
) -> CurveEstimate:
    """Return the estimate of a fit; `covariance` is that of (q, u, omega), shape (5, 5).

    `began_beyond`: whether the fit began beyond the peak, and slips have not been on the stable side since: where the
    peak is then is told by the bend of a curve that is flat there.
    """
    theta = burckhardt_log.to_theta(q)
    of_q = covariance[:3, :3]
    jacobian = burckhardt_log.theta_jacobian(theta)
    peak = burckhardt_log.peak(q)
    lambda_stddev = peak.lambda_max * sqrt(max(float(peak.lambda_gradient @ of_q @ peak.lambda_gradient), 0.0))
    mu_stddev = sqrt(max(float(peak.mu_gradient @ of_q @ peak.mu_gradient), 0.0))
    reason, text = limits.judge(samples, slip_span, peak.lambda_max, lambda_stddev)
    if reason is Reason.OK and began_beyond:
        reason = Reason.UNCERTAIN
        text = "the fit began beyond the peak, and slips have not come back to its stable side"

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
        theta_covariance=jacobian @ of_q @ jacobian.T,
        mu=here.friction,
        slope=here.slope,
        slope_stddev=sqrt(max(float(row @ covariance @ row), 0.0)),
        probability_beyond_peak=probability_negative(-beyond, spread),
        restart_cause=cause,
        reason=reason,
        text=text,
    )
