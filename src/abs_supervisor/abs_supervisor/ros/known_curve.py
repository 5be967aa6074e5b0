"""lambda_max of <wheel>/friction_curve as far as the supervisor may rely on it."""

from math import hypot, inf, isfinite, nan
from typing import Final

from friction_msgs.msg import FrictionCurve

from abs_supervisor.curve_queue import CurveQueue
from friction_runtime.filters import Debounce
from friction_runtime.messages import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason

_KEPT: Final = 15.0
"""[m] for which a curve counts after the last that told or confirmed its peak (half a second at 30 m/s): while a wheel
dives the fit has none, or takes the dive for another road and begins anew, and near standstill there is none at all.
Another road comes with the distance, not with the time."""
_FEWEST: Final = 20
"""Samples of a fit that says something about the road."""
_OK = Reason.OK
_UNKNOWN_CAR = Reason.UNKNOWN_CAR
"""As good as OK here: torque and curve share what is wrong about the car."""
_UNCERTAIN = Reason.UNCERTAIN
"""lambda_max speaks of the road, with its standard deviation."""
_AHEAD = Reason.PEAK_NOT_PASSED
"""The peak is still ahead: that tells no peak itself, but may confirm an earlier one or contradict an uncertain one."""
_USED = (_OK, _UNKNOWN_CAR, _UNCERTAIN, _AHEAD)
_CONTRADICTS: Final = 3.0
"""Standard deviations of both by which a peak that is ahead then lies beyond the earlier one."""
_PRECISE: Final = 0.25
"""Standard deviation relative to lambda_max up to which a fit says so much that it confirms an earlier one."""
_SETTLED: Final = round(0.05 * NANOSECONDS)
"""[ns] for which the fits must have told a peak before an uncertain one counts. When braking begins, the first can be
off by any number of its standard deviations: where the wheel speed has more noise than the sensor's data say, the slips
that it was fitted to are not the true ones."""
_FORESEEN: Final = 0.15
"""Standard deviation relative to lambda_max up to which a peak ahead is foreseen, not guessed by the prior."""
_DOUBT: Final = 3.0
"""By so much its standard deviation is raised: the model it relies on has not been tried yet."""

Peak = tuple[float, float]
"""lambda_max and its standard deviation [-]."""


class _Curve:
    """What a fit says of the peak as of a stamp [ns]; None where it says nothing."""

    __slots__ = ("peak", "reason", "stamp")

    def __init__(self, stamp: int, peak: Peak | None, reason: int) -> None:
        self.stamp = stamp
        self.peak = peak
        self.reason = reason


class KnownCurve:
    """The curves of one wheel by their stamps."""

    def __init__(self, foresees: bool) -> None:
        """Start without curves; `foresees`: a peak ahead counts where the fit is sure of it."""
        self._foresees = foresees
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._curves: CurveQueue[_Curve] = CurveQueue()
        self._known: Peak | None = None
        self._known_at = 0.0
        self._uncertain = False
        self._ahead = False
        self._driven = 0.0
        self._stamp: int | None = None
        self._told = Debounce(_SETTLED)

    def take(self, message: FrictionCurve) -> int:
        """Take a curve, in whichever order they come; return from which stamp on it counts [ns].

        One without a stamp is not taken.
        """
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            return stamp
        peak: Peak | None = None
        reason = message.validity.reason
        if reason in _USED and message.samples >= _FEWEST and 0.0 < message.lambda_max < 1.0:
            doubt = message.lambda_max_stddev
            peak = message.lambda_max, doubt if isfinite(doubt) else 0.0
        return self._curves.put(stamp, _Curve(stamp, peak, reason))

    def at(self, stamp: int, speed: float) -> Peak:
        """Return lambda_max and its standard deviation for a sample, NaN where it is not known.

        Args:
            stamp: of the sample [ns]; it does not go back, but with a reset.
            speed: of the car [m/s], NaN where unknown.
        """
        if self._stamp is not None and speed > 0.0:
            self._driven += speed * (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        for curve in self._curves.until(stamp):
            self._follow(curve)
        if self._known is not None and self._driven - self._known_at > _KEPT:
            self._known = None
        return self._known or (nan, nan)

    def _follow(self, curve: _Curve) -> None:
        peak, known = curve.peak, self._known
        if peak is None or curve.reason == _AHEAD:
            self._told.reset()
            if peak is not None and known is not None and not self._ahead:
                self._compare(peak, known)
            if peak is not None and self._foresees and (self._known is None or self._ahead):
                self._foresee(peak)
            return
        if not self._told.update(curve.stamp, True) and curve.reason == _UNCERTAIN:
            return
        # What was seen needs as much to be given up as by a guess.
        beyond = _CONTRADICTS if curve.reason == _UNCERTAIN and not self._uncertain else 1.0
        if known is not None and not self._ahead and _only_vaguer(peak, known, beyond):
            if _is_precise(peak):
                self._known_at = self._driven
            return
        self._known, self._known_at, self._uncertain = peak, self._driven, curve.reason == _UNCERTAIN
        self._ahead = False

    def _foresee(self, peak: Peak) -> None:
        self._ahead = peak[1] <= _FORESEEN * peak[0]
        self._known, self._known_at = (peak[0], _DOUBT * peak[1]) if self._ahead else None, self._driven

    def _compare(self, ahead: Peak, known: Peak) -> None:
        if _further(ahead, known) <= _CONTRADICTS:
            if _is_precise(ahead):
                self._known_at = self._driven
        elif self._uncertain:  # else a guess does not outweigh what was seen
            self._known = None


def _further(newer: Peak, known: Peak) -> float:
    """Return by how many standard deviations of both a newer peak lies beyond an earlier one."""
    beyond = newer[0] - known[0]
    doubt = hypot(newer[1], known[1])
    return beyond / doubt if doubt > 0.0 else 0.0 if beyond <= 0.0 else inf


def _only_vaguer(newer: Peak, known: Peak, deviations: float) -> bool:
    """Whether a newer peak is less certain than an earlier one, and by less than so many deviations beyond it."""
    return newer[1] > known[1] and newer[0] - known[0] <= deviations * newer[1]


def _is_precise(peak: Peak) -> bool:
    return peak[1] <= _PRECISE * peak[0]
