"""lambda_max of <wheel>/friction_curve as far as the supervisor may rely on it."""

from collections import deque
from math import isfinite, nan

from friction_msgs.msg import FrictionCurve

from friction_runtime.stamps import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

_OLDER = round(0.05 * NANOSECONDS)
"""[ns] a curve counts for samples at least this much later: by then it has come, so that the answer to a sample does
not depend on which of the two came first."""
_KEPT = round(0.5 * NANOSECONDS)
"""[ns] for which a curve counts after the last that told a peak: while a wheel dives the fit has none, or takes the
dive for another road and begins anew."""
_FEWEST = 20
"""Samples of a fit that says something about the road."""
_USED = (int(FrictionCurve.OK), int(FrictionCurve.UNCERTAIN))
"""Reasons with which lambda_max speaks of the road: an uncertain one does so with its standard deviation."""

Peak = tuple[float, float]


class KnownCurve:
    """The curves of one wheel by their stamps."""

    def __init__(self) -> None:
        """Start without curves."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._curves: deque[tuple[int, Peak]] = deque()

    def take(self, message: FrictionCurve) -> int:
        """Take a curve, in whichever order they come; return from which stamp on it counts [ns].

        One without a stamp is not taken.
        """
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            return stamp
        known = message.reason in _USED and message.samples >= _FEWEST and 0.0 < message.lambda_max < 1.0
        if known:
            doubt = message.lambda_max_stddev
            self._insert(stamp, (message.lambda_max, doubt if isfinite(doubt) else 0.0))
        return stamp + _OLDER

    def _insert(self, stamp: int, peak: Peak) -> None:
        later = [each for each in self._curves if each[0] > stamp]
        while self._curves and self._curves[-1][0] >= stamp:
            self._curves.pop()
        self._curves.append((stamp, peak))
        self._curves.extend(later)

    def at(self, stamp: int) -> Peak:
        """Return lambda_max and its standard deviation for a sample at a stamp [ns], NaN where it is not known."""
        curves = self._curves
        while len(curves) > 1 and curves[1][0] <= stamp - _OLDER:
            curves.popleft()
        if not curves or not stamp - _KEPT <= curves[0][0] <= stamp - _OLDER:
            return nan, nan
        return curves[0][1]
