"""Slip and speed of the car as the identified curve has them, for the law that holds a slip of that curve.

A curve is fitted with a speed of its own. Where a wheel has been held at one slip for long, nothing shows the speed of
the car: slip and curve then drift apart, each within its deviation, and a set-point of the one held by the other is
wrong by both. The two are joined by their variances.
"""

from collections import deque
from math import isfinite, nan
from typing import Final

from abs_supervisor.curve_selector import CurveReport
from abs_supervisor.measurements import Measurements
from vehicle_models.nanoseconds import NANOSECONDS

CURVE_SLIP: Final = 0.01
"""[-] standard deviation of the slip of a curve beside its own: of what the model of the car leaves out."""
RATIO_TIME: Final = 0.1
"""[s] over which the ratio of the two speeds is meant: what is shorter is the delay of one of them."""
LARGEST_SLIP: Final = 0.5
"""[-] beyond which the two are not compared: a wheel that dives has another slip each millisecond."""
_KEPT: Final = round(0.25 * NANOSECONDS)
"""[ns] for which a slip is kept: curves count 0.05 s after their stamp, or later."""


class CurveSpeed:
    """Follows the ratio of the two speeds."""

    def __init__(self) -> None:
        """Begin where both agree."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._slips: deque[tuple[int, float]] = deque()
        self.forget()

    def forget(self) -> None:
        """Forget the ratio: there is no curve."""
        self._ratio, self._variance, self._compared = 1.0, CURVE_SLIP**2, 0

    def take(self, report: CurveReport) -> None:
        """Take the slip that came with a curve, where it has a deviation."""
        stamp, slip, stddev = report.stamp, report.slip, report.slip_stddev
        if stamp <= self._compared:  # most samples come between two curves
            return
        measured = next((each for at, each in self._slips if at == stamp), nan)
        if isfinite(measured + slip + stddev) and max(abs(measured), abs(slip)) < LARGEST_SLIP:
            weight = min((stamp - self._compared) / (RATIO_TIME * NANOSECONDS), 1.0)
            self._ratio += weight * ((1.0 - measured) / (1.0 - slip) - self._ratio)
            self._variance, self._compared = stddev**2 + CURVE_SLIP**2, stamp

    def by_curve(self, stamp: int, measured: Measurements) -> Measurements:
        """Return the measurements at a stamp [ns] with slip and speed of the car joined with those of the curve."""
        self._slips.append((stamp, measured.slip))
        while stamp - self._slips[0][0] > _KEPT:
            self._slips.popleft()
        variance = measured.slip_stddev**2
        if not isfinite(variance):
            return measured
        ratio = 1.0 + (self._ratio - 1.0) * variance / (variance + self._variance)
        slip = 1.0 - (1.0 - measured.slip) / ratio
        return measured._replace(slip=slip, car_speed=measured.car_speed * ratio)
