"""<wheel>/friction_curve as reports for the law, in the order of their stamps."""

from collections import deque
from math import isnan

from friction_msgs.msg import FrictionCurve

from abs_supervisor.law.road_curve import RoadCurve, curve_through
from abs_supervisor.law.usable_curve import CurveReport, Estimate
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

_OLDER = round(0.05 * NANOSECONDS)
"""[ns] as for the envelope: by then a curve has come, whichever of it and the sample was first."""
_ESTIMATES = {
    int(FrictionCurve.OK): Estimate.VALID,
    int(FrictionCurve.UNKNOWN_CAR): Estimate.VALID,
    int(FrictionCurve.PEAK_NOT_PASSED): Estimate.VAGUE,
    int(FrictionCurve.UNCERTAIN): Estimate.VAGUE,
    int(FrictionCurve.NO_EXCITATION): Estimate.QUIET,
    int(FrictionCurve.LOW_SPEED): Estimate.QUIET,
}


class CurveReports:
    """Holds the curves of one wheel until they count."""

    def __init__(self) -> None:
        """Start without curves."""
        self.reset()

    def reset(self) -> None:
        """Forget all of them."""
        self._waiting: deque[CurveReport] = deque()
        self._counted = 0

    def take(self, message: FrictionCurve) -> None:
        """Take a curve; one that is older than another that counts already is left out."""
        report = _report(message)
        if report.stamp <= self._counted:
            return
        later = []
        while self._waiting and self._waiting[-1].stamp >= report.stamp:
            each = self._waiting.pop()
            if each.stamp > report.stamp:
                later.append(each)
        self._waiting.append(report)
        self._waiting.extend(reversed(later))

    def until(self, stamp: int) -> list[CurveReport]:
        """Return the reports that count from now on, at a sample with a stamp [ns], oldest first."""
        found = []
        while self._waiting and self._waiting[0].stamp <= stamp - _OLDER:
            found.append(self._waiting.popleft())
        if found:
            self._counted = found[-1].stamp
        return found


def _curve(message: FrictionCurve) -> RoadCurve:
    if isnan(message.theta_1):
        # A method may know the peak by another family than Burckhardt's.
        return curve_through(message.lambda_max, message.mu_max)
    return RoadCurve(message.theta_1, message.theta_2, message.theta_3, message.lambda_max)


def _report(message: FrictionCurve) -> CurveReport:
    estimate = _ESTIMATES.get(message.reason, Estimate.NONE)
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
    )
