"""Curve selector: the friction curve that counts, for the law and for the threshold of a release.

Curves come in whichever order, and count by their stamps.
"""

from collections import deque
from enum import Enum
from math import isfinite, nan
from typing import Final

from abs_supervisor.road_curve import RoadCurve
from vehicle_models.nanoseconds import NANOSECONDS

_OLDER: Final = round(0.05 * NANOSECONDS)
"""[ns] a curve counts for samples at least this much later: by then it has come, so that the answer to a sample does
not depend on which of the two came first."""

_FEWEST: Final = 20
"""Samples of a fit that says something of the road."""
_SEEN_AFTER: Final = 3
"""Valid estimates after which the peak counts as seen."""
_VAGUE: Final = 0.25
"""Of lambda_max: once the peak was seen, estimates with a larger standard deviation are left out, but for one that is
less vague than the present. Where no estimate has been valid, the present one stays for _KEPT only: a fit on its way
is sure for a moment of what it gives up the next."""
_ALIKE: Final = 1.25
"""Ratio of the friction of two curves at one slip, up to which they may be of one road."""
_KEPT = round(0.15 * NANOSECONDS)
"""[ns] for which the last curve serves when the estimator has none for another reason than that nothing moves, and one
that never was valid when newer ones are vaguer."""


class Estimate(Enum):
    """What the estimator says of its own estimate."""

    VALID = "valid"
    VAGUE = "not sure"
    """The peak has not been passed, or its place is uncertain."""
    QUIET = "quiet"
    """Nothing moves: the last curve stays right."""
    NONE = "none"


class CurveReport:
    """One message of the estimator."""

    __slots__ = ("beyond", "curve", "estimate", "of_tyre", "restarts", "samples", "stamp", "stddev")

    def __init__(
        self,
        stamp: int,
        estimate: Estimate,
        curve: RoadCurve | None,
        stddev: float,
        beyond: float,
        samples: int,
        restarts: int,
        of_tyre: bool = False,
    ) -> None:
        """Take what was said.

        Args:
            stamp: [ns].
            estimate: of what kind.
            curve: None where there is none.
            stddev: of lambda_max [-], NaN where unknown.
            beyond: probability that the slip is beyond the peak, NaN where unknown.
            samples: in the fit.
            restarts: of the fit, counted.
            of_tyre: whether friction is that of the tyre, with the load of each wheel known.
        """
        self.stamp = stamp
        self.estimate = estimate
        self.curve = curve
        self.stddev = stddev
        self.beyond = beyond
        self.samples = samples
        self.restarts = restarts
        self.of_tyre = of_tyre


class CurveSelector:
    """Follows the estimates of one wheel: `put` them, and `advance` at every sample."""

    def __init__(self) -> None:
        """Start without a curve."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._waiting: deque[CurveReport] = deque()
        self._counted = 0
        self.of_tyre = False
        """Whether friction is that of the tyre: in that of one wheel alone the change of its load is contained."""
        self.forget()

    def forget(self) -> None:
        """Forget the curve that counts, as when a braking is over."""
        self.curve: RoadCurve | None = None
        """The road; None where it is not known."""
        self.seen = False
        """Whether the slip has passed its peak."""
        self._changed = False
        self._restarts = self._level_restarts = -1
        self._doubt = 0.0
        self._valid = 0
        self._since = self._taken = 0

    @property
    def lambda_max(self) -> float:
        """Slip at the peak [-]; NaN where no curve counts."""
        return nan if self.curve is None else self.curve.lambda_max

    @property
    def lambda_max_stddev(self) -> float:
        """Its standard deviation [-]."""
        return nan if self.curve is None else self._doubt * self.curve.lambda_max

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
        """Let the curves count that are old enough at a stamp [ns]; return whether one of them is of another road.

        Args:
            stamp: of the sample, later than the last.
            explained: whether the present curve explains how the wheel moves. A fit that began anew then displaces it
                only if it has another friction at the known peak, or is surer of its own. Else its samples are of the
                slips that the law held: they show the level of friction, hardly the peak. A present curve that was
                vague itself holds for _KEPT only.
        """
        changed = False
        while self._waiting and self._waiting[0].stamp <= stamp - _OLDER:
            report = self._waiting.popleft()
            self._counted = report.stamp
            self._take(report, explained and not changed)
            changed = changed or self._changed
        return changed

    def _take(self, report: CurveReport, explained: bool) -> None:
        self._changed, self.of_tyre = False, report.of_tyre
        curve, known = report.curve, self.curve
        tells = curve is not None and report.samples >= _FEWEST
        doubt = report.stddev / curve.lambda_max if curve is not None and isfinite(report.stddev) else 0.0
        vague = doubt > _VAGUE
        anew = report.restarts != self._restarts
        sure = self._doubt <= _VAGUE
        kept = sure or report.stamp - self._since <= _KEPT
        if curve is not None and known is not None and anew and explained and kept:
            level = curve.friction(known.lambda_max) / known.mu_max
            same = doubt > self._doubt and 1.0 / _ALIKE < level < _ALIKE
            if vague or same:
                if sure:  # a peak that was vague itself is not kept by what says nothing of it
                    self._since = report.stamp
                if tells and not vague:
                    self._take_level(report.restarts, known, level)
                return
        if tells and report.estimate in (Estimate.VALID, Estimate.VAGUE):
            if anew:
                self._changed = self._restarts >= 0
                self._restarts, self._valid, self.seen = report.restarts, 0, False
            self._valid += report.estimate is Estimate.VALID
            self.seen = self.seen or self._valid >= _SEEN_AFTER or report.beyond > 0.5
            lasts = self._valid >= _SEEN_AFTER or report.stamp - self._taken <= _KEPT
            if not (self.seen and vague and lasts) or self.curve is None or self._changed or doubt < self._doubt:
                self.curve, self._doubt, self._taken = curve, doubt, report.stamp
            self._since = report.stamp
        elif report.estimate is Estimate.QUIET:
            self._since = report.stamp
        elif report.stamp - self._since > _KEPT:
            self.curve = None

    def _take_level(self, restarts: int, known: RoadCurve, level: float) -> None:
        """Take from a fit, the one that follows so many restarts, what it says of the friction at the known peak."""
        self._changed = restarts != self._level_restarts
        self._level_restarts = restarts
        self.curve = RoadCurve(known.theta_1 * level, known.theta_2, known.theta_3 * level, known.lambda_max)
