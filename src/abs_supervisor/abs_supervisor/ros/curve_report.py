"""<wheel>/friction_curve as a report for the curve selector."""

from math import isfinite, isnan, nan

from friction_msgs.msg import FrictionCurve

from abs_supervisor.curve_selector import CurveReport, Estimate
from abs_supervisor.road_curve import RoadCurve, curve_through
from friction_runtime.messages import to_nanoseconds
from vehicle_models.reason import Reason

_ESTIMATES: dict[int, Estimate] = {
    Reason.OK: Estimate.VALID,
    Reason.UNKNOWN_CAR: Estimate.VALID,
    Reason.PEAK_NOT_PASSED: Estimate.VAGUE,
    Reason.UNCERTAIN: Estimate.VAGUE,
    Reason.NO_EXCITATION: Estimate.QUIET,
    Reason.LOW_SPEED: Estimate.QUIET,
}
_OF_THE_TYRE = "car"
"""Method whose friction is that of the tyre."""


def curve_report(message: FrictionCurve) -> CurveReport:
    """Return what a message says; one whose parameters are no curve says that there is none."""
    estimate = _ESTIMATES.get(message.validity.reason, Estimate.NONE)
    curve = None
    if estimate in (Estimate.VALID, Estimate.VAGUE):
        try:
            curve = _curve(message)
        except ValueError:
            estimate = Estimate.NONE
    return CurveReport(
        to_nanoseconds(message.header.stamp),
        estimate,
        curve,
        message.lambda_max_stddev,
        message.probability_beyond_peak,
        message.samples,
        message.restarts,
        message.method == _OF_THE_TYRE,
    )


def _curve(message: FrictionCurve) -> RoadCurve:
    if isnan(message.theta_1):
        # A method may know the peak by another family than Burckhardt's, and its height not yet.
        mu_max = message.mu_max
        if not isfinite(mu_max):
            share = curve_through(message.lambda_max, 1.0).friction(message.slip)
            mu_max = message.mu / share if share > 0.0 else nan
        return curve_through(message.lambda_max, mu_max)
    return RoadCurve(message.theta_1, message.theta_2, message.theta_3, message.lambda_max)
