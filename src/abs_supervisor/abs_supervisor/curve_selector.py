"""Curve selector: the friction curve that counts, for the law and for the threshold of a release.

Curves come in whichever order, and count by their stamps.
"""

from collections import deque
from enum import Enum
from math import isfinite, nan
from typing import Final, NamedTuple

from abs_supervisor.road_curve import RoadCurve
from vehicle_models.nanoseconds import NANOSECONDS

_OLDER: Final = round(0.05 * NANOSECONDS)
"""[ns] a curve counts for samples at least this much later: by then it has come, so that the answer to a sample does
not depend on which of the two came first."""

_FEWEST: Final = 20
"""Samples of a fit below which it shows nothing of the road."""
_UNCERTAIN: Final = 0.25
"""[-] standard deviation over lambda_max: above, a fit replaces only one that is less certain."""
_ALIKE: Final = 1.25
"""[-] ratio of the friction of two curves at one slip, up to which they may be of one road."""
CURVE_KEPT: Final = round(0.15 * NANOSECONDS)
"""[ns] for which a braking waits for its first curve, and for which the last one serves when the estimator has none for
another reason than that nothing moves."""


class Estimate(Enum):
    """Verdict of the estimator on its own estimate."""

    VALID = "valid"
    VAGUE = "uncertain"
    """The peak has not been passed, or its place is uncertain."""
    QUIET = "quiet"
    """Nothing moves: the last curve stays right."""
    NONE = "none"


class CurveReport(NamedTuple):
    """One message of the estimator."""

    stamp: int
    """[ns]"""
    estimate: Estimate
    curve: RoadCurve | None
    stddev: float
    """Of lambda_max [-], NaN where unknown."""
    beyond: float
    """Probability that the slip is beyond the peak, NaN where unknown."""
    samples: int
    """In the fit."""
    restarts: int
    """Of the fit, counted."""
    of_tyre: bool = False
    """Whether friction is that of the tyre, with the load of each wheel known."""
    slip: float = nan
    """Of the wheel at the stamp, by the speed that the curve is of [-]."""
    slip_stddev: float = nan


class CurveSelector:
    """Follows the estimates of one wheel: `put` them, and `advance` at every sample."""

    def __init__(self) -> None:
        """Start without a curve."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._waiting: deque[CurveReport] = deque()
        self._counted = 0
        self.report: CurveReport | None = None
        """The newest that counts."""
        self.forget()

    def forget(self) -> None:
        """Forget the curve that counts, as when a braking is over."""
        self.curve: RoadCurve | None = None
        """The road; None where it is not known."""
        self.seen = False
        """Whether the slip has passed its peak."""
        self._restarts = -1
        self._valid = False
        self._uncertainty = 0.0
        self._since = 0

    @property
    def of_tyre(self) -> bool:
        """Whether friction is that of the tyre: in that of one wheel alone the change of its load is contained."""
        return self.report is not None and self.report.of_tyre

    @property
    def lambda_max(self) -> float:
        """Slip at the peak [-]; NaN where no curve counts."""
        return nan if self.curve is None else self.curve.lambda_max

    @property
    def lambda_max_stddev(self) -> float:
        """Its standard deviation [-]."""
        return nan if self.curve is None else self._uncertainty * self.curve.lambda_max

    def put(self, report: CurveReport) -> int:
        """Take what the estimator reports; return from which stamp on it counts [ns].

        One replaces another of its stamp. One that is older than another that counts already is left out.
        """
        if report.stamp > self._counted:
            later = [each for each in self._waiting if each.stamp > report.stamp]
            while self._waiting and self._waiting[-1].stamp >= report.stamp:
                self._waiting.pop()
            self._waiting.append(report)
            self._waiting.extend(later)
        return report.stamp + _OLDER

    def advance(self, stamp: int, explained: bool) -> bool:
        """Let the curves count that are old enough; return whether one of them is of another road.

        Args:
            stamp: of the sample [ns], later than the last.
            explained: whether the present curve explains how the wheel moves. A fit that began anew is then one of the
                same road, of the slips that the law held, which show hardly its peak.
        """
        changed = False
        while self._waiting and self._waiting[0].stamp <= stamp - _OLDER:
            report = self._waiting.popleft()
            self._counted = report.stamp
            changed = self._take(report, explained and not changed) or changed
        return changed

    def _take(self, report: CurveReport, explained: bool) -> bool:
        self.report, curve = report, report.curve
        if report.estimate is Estimate.QUIET:
            self._since = report.stamp
        elif curve is None or report.samples < _FEWEST:
            if report.stamp - self._since > CURVE_KEPT:
                self.curve = None
        else:
            first, anew = self.curve is None, report.restarts != self._restarts
            uncertainty = report.stddev / curve.lambda_max if isfinite(report.stddev) else 0.0
            self._since = report.stamp
            if anew and explained and self._is_better(curve, uncertainty):
                return False
            self._valid = (self._valid and not anew) or report.estimate is Estimate.VALID
            if not self._valid or first or anew or uncertainty < max(_UNCERTAIN, self._uncertainty):
                self.curve, self._uncertainty = curve, uncertainty
            self._restarts = report.restarts
            self.seen = (self.seen and not anew) or self._valid or report.beyond > 0.5
            return anew and not first
        return False

    def _is_better(self, curve: RoadCurve, uncertainty: float) -> bool:
        """Whether the present curve, which explains the wheel's motion, is better than one of a fit that began anew."""
        if self.curve is None or self._uncertainty > _UNCERTAIN or uncertainty < self._uncertainty:
            return False
        level = curve.friction(self.curve.lambda_max) / self.curve.mu_max
        return uncertainty > _UNCERTAIN or 1.0 / _ALIKE < level < _ALIKE
