"""Which of the estimates of the friction curve the law uses."""

from enum import Enum
from math import inf, isfinite
from typing import Final

from abs_supervisor.law.road_curve import RoadCurve
from vehicle_models.nanoseconds import NANOSECONDS

_FEWEST: Final = 20
"""Samples of a fit that says something of the road."""
_SEEN_AFTER: Final = 3
"""Valid estimates after which the peak counts as seen."""
_VAGUE: Final = 0.25
"""Of lambda_max: once the peak was seen, estimates with a larger standard deviation are left out, but for one that is
less vague than the present."""
_KEPT = round(0.15 * NANOSECONDS)
"""[ns] for which the last curve serves when the estimator has none for another reason than that nothing moves."""


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
        self._restarts = -1
        self._doubt = inf
        self.valid = 0
        """Valid estimates of this road."""
        self._since = 0

    def take(self, report: CurveReport, explained: bool = False) -> None:
        """Take a report; their stamps do not go back.

        Args:
            report: of the estimator.
            explained: whether the present curve explains how the wheel moves. A fit that began anew is then no reason
                to believe in another road until it is sure of one.
        """
        self.changed = False
        curve = report.curve
        tells = curve is not None and report.samples >= _FEWEST
        doubt = report.stddev / curve.lambda_max if curve is not None and isfinite(report.stddev) else 0.0
        vague = doubt > _VAGUE
        anew = report.restarts != self._restarts
        if self.curve is not None and anew and vague and explained:
            self._since = report.stamp
        elif tells and report.estimate in (Estimate.VALID, Estimate.VAGUE):
            if anew:
                self.changed = self._restarts >= 0
                self._restarts, self.valid, self.seen = report.restarts, 0, False
            self.valid += report.estimate is Estimate.VALID
            self.seen = self.seen or self.valid >= _SEEN_AFTER or report.beyond > 0.5
            if not (self.seen and vague) or self.curve is None or self.changed or doubt < self._doubt:
                self.curve, self._doubt = curve, doubt
            self._since = report.stamp
        elif report.estimate is Estimate.QUIET:
            self._since = report.stamp
        elif report.stamp - self._since > _KEPT:
            self.curve = None
