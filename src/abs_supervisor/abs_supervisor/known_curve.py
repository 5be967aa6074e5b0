"""lambda_max of <wheel>/friction_curve as far as the supervisor may rely on it."""

from collections import deque
from math import hypot, isfinite, nan

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
_AHEAD = int(FrictionCurve.PEAK_NOT_PASSED)
"""The peak is still ahead: that may contradict an earlier curve, and tells no peak itself."""
_CONTRADICTS = 3.0
"""Standard deviations of both by which it then lies beyond the earlier one."""

_FORESEEN = 0.15
"""Standard deviation over lambda_max up to which a peak that lies ahead is foreseen, not guessed by the prior."""
_DOUBT = 3.0
"""By so much its standard deviation is raised: the model it relies on has not been tried yet."""

Peak = tuple[float, float]


class _Curve:
    """lambda_max with its standard deviation [-] as of a stamp [ns]."""

    __slots__ = ("ahead", "peak", "stamp")

    def __init__(self, stamp: int, peak: Peak, ahead: bool) -> None:
        self.stamp = stamp
        self.peak = peak
        self.ahead = ahead


class KnownCurve:
    """The curves of one wheel by their stamps."""

    def __init__(self, foresees: bool) -> None:
        """Start without curves; `foresees`: a peak ahead counts where the fit is sure of it."""
        self._foresees = foresees
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._curves: deque[_Curve] = deque()
        self._known: _Curve | None = None

    def take(self, message: FrictionCurve) -> int:
        """Take a curve, in whichever order they come; return from which stamp on it counts [ns].

        One without a stamp is not taken.
        """
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            return stamp
        ahead = message.reason == _AHEAD
        told = message.samples >= _FEWEST and 0.0 < message.lambda_max < 1.0
        if told and (ahead or message.reason in _USED):
            doubt = message.lambda_max_stddev
            self._insert(_Curve(stamp, (message.lambda_max, doubt if isfinite(doubt) else 0.0), ahead))
        return stamp + _OLDER

    def _insert(self, curve: _Curve) -> None:
        later = [each for each in self._curves if each.stamp > curve.stamp]
        while self._curves and self._curves[-1].stamp >= curve.stamp:
            self._curves.pop()
        self._curves.append(curve)
        self._curves.extend(later)

    def at(self, stamp: int) -> Peak:
        """Return lambda_max and its standard deviation for a sample at a stamp [ns], NaN where it is not known.

        Stamps do not go back, but with a reset.
        """
        curves = self._curves
        while curves and curves[0].stamp <= stamp - _OLDER:
            curve = curves.popleft()
            if not curve.ahead:
                self._known = curve
                continue
            known = self._known
            expired = self._foresees and known is not None and known.stamp < curve.stamp - _KEPT
            if known is not None and (expired or known.ahead or _contradicts(curve.peak, known.peak)):
                self._known = None
            if self._foresees and self._known is None and curve.peak[1] <= _FORESEEN * curve.peak[0]:
                self._known = _Curve(curve.stamp, (curve.peak[0], _DOUBT * curve.peak[1]), True)
        known = self._known
        return known.peak if known is not None and known.stamp >= stamp - _KEPT else (nan, nan)


def _contradicts(ahead: Peak, known: Peak) -> bool:
    return ahead[0] - known[0] > _CONTRADICTS * hypot(ahead[1], known[1])
