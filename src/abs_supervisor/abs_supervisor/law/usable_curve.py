"""Selection of the friction curve that the slip controller uses."""

from enum import Enum
from math import isfinite
from typing import Final

from abs_supervisor.law.road_curve import RoadCurve
from vehicle_models.nanoseconds import NANOSECONDS

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

    __slots__ = ("beyond", "curve", "estimate", "restarts", "samples", "stamp", "stddev")

    def __init__(
        self,
        stamp: int,
        estimate: Estimate,
        curve: RoadCurve | None,
        stddev: float,
        beyond: float,
        samples: int,
        restarts: int,
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
        """
        self.stamp = stamp
        self.estimate = estimate
        self.curve = curve
        self.stddev = stddev
        self.beyond = beyond
        self.samples = samples
        self.restarts = restarts


class UsableCurve:
    """Follows the estimates of one wheel."""

    def __init__(self) -> None:
        """Start without a curve."""
        self.reset()

    def reset(self) -> None:
        """Forget everything, as when a braking is over."""
        self.curve: RoadCurve | None = None
        """The road; None where it is not known."""
        self.seen = False
        """Whether the slip has passed its peak."""
        self.changed = False
        """Whether the last report brought another road."""
        self._restarts = self._level_restarts = -1
        self._doubt = 0.0
        self.valid = 0
        """Valid estimates of this road."""
        self._since = self._taken = 0

    def take(self, report: CurveReport, explained: bool = False) -> None:
        """Take a report; their stamps do not go back.

        Args:
            report: of the estimator.
            explained: whether the present curve explains how the wheel moves. A fit that began anew then displaces it
                only if it says another friction at the known peak, or is surer of its own. Else its samples are of the
                slips that the law held: they tell the level of friction, hardly the peak. A present curve that was
                vague itself holds for _KEPT only.
        """
        self.changed = False
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
                self.changed = self._restarts >= 0
                self._restarts, self.valid, self.seen = report.restarts, 0, False
            self.valid += report.estimate is Estimate.VALID
            self.seen = self.seen or self.valid >= _SEEN_AFTER or report.beyond > 0.5
            lasts = self.valid >= _SEEN_AFTER or report.stamp - self._taken <= _KEPT
            if not (self.seen and vague and lasts) or self.curve is None or self.changed or doubt < self._doubt:
                self.curve, self._doubt, self._taken = curve, doubt, report.stamp
            self._since = report.stamp
        elif report.estimate is Estimate.QUIET:
            self._since = report.stamp
        elif report.stamp - self._since > _KEPT:
            self.curve = None

    def _take_level(self, restarts: int, known: RoadCurve, level: float) -> None:
        """Take from a fit, the one that follows so many restarts, what it says of the friction at the known peak."""
        self.changed = restarts != self._level_restarts
        self._level_restarts = restarts
        self.curve = RoadCurve(known.theta_1 * level, known.theta_2, known.theta_3 * level, known.lambda_max)
