"""Slip that the contact of a tyre has built up, which is the slip that its friction follows.

    L s_dot = v (lambda - s)

The peak of the friction is passed when s passes lambda_max, L / v later than the slip lambda of the wheel.
"""

from math import isnan, nan

from friction_runtime.filters import first_order_gain
from vehicle_models.nanoseconds import NANOSECOND


class TyreRelaxation:
    """Follows the slip of one wheel over the distance that it rolls."""

    def __init__(self, length: float) -> None:
        """Start without a slip; `length` is the relaxation length L [m], > 0."""
        self._length = length
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next slip is taken to be built up."""
        self._slip = nan
        self._stamp = 0

    def update(self, stamp: int, slip: float, speed: float) -> float:
        """Return the slip built up [-], NaN where slip or speed are not known.

        Args:
            stamp: [ns], later than the last.
            slip: slip of the wheel [-].
            speed: speed of the car [m/s]; backwards counts as standing.
        """
        if isnan(slip) or isnan(speed):
            self._slip = nan
        elif isnan(self._slip):
            self._slip = slip
        else:
            rolled = max(speed, 0.0) * (stamp - self._stamp) * NANOSECOND
            self._slip += first_order_gain(rolled, self._length) * (slip - self._slip)
        self._stamp = stamp
        return self._slip
