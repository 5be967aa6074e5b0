"""Sign of the slope from the indicator: two thresholds, a record of the crossings, and a memory of confident signs.

A friction curve has one peak: a wheel below a slip that was surely stable is stable, one above a slip that was surely
beyond the peak is beyond it, while the indicator gives no sign. Another road has another curve, so such slips are soon
forgotten, and a contradiction makes them forgotten at once.
"""

from collections.abc import Callable
from math import inf, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

MEMORY: Final = round(1.0 * NANOSECONDS)
"""Time for which a told slip counts [ns]."""
NEARER: Final = 0.8
"""Share that a slip must keep to, of one that was told: for the errors of slip."""


class CrossingDetector:
    """Holds the sign between the thresholds: -1 at or below the negative one, +1 at or above the positive one."""

    def __init__(self, h_instability: float, h_stability: float) -> None:
        """Start with an unknown sign.

        Args:
            h_instability: threshold of the unstable side [rad/s^3], <= 0.
            h_stability: threshold of the stable side [rad/s^3], >= 0.

        Raises:
            ValueError: a threshold has the wrong sign.
        """
        if not h_instability <= 0.0 <= h_stability:
            raise ValueError(f"h_instability ({h_instability}) must be <= 0 and h_stability ({h_stability}) >= 0")
        self._h_instability, self._h_stability = h_instability, h_stability
        self.reset()

    def reset(self) -> None:
        """Forget sign and crossings."""
        self.sign = 0
        """+1, -1, or 0 where it is not known (yet)."""
        self.crossings = 0
        """Changes of sign."""
        self.crossing_sign = 0
        """Sign after the last crossing."""
        self.slip = nan
        """Slip at the last crossing [-]."""
        self.stamp = 0
        """Time of the last crossing [ns]."""
        self.since = 0
        """Time from which on the sign has been told and no indicator was against it [ns]."""
        self._told = 0

    def forget_sign(self) -> None:
        """Make the sign unknown and keep the record."""
        self.sign = 0

    def update(self, indicator: float, growing: int, slip: Callable[[], float], stamp: int, trial: int = 0) -> None:
        """Take the indicator at the time for which it holds.

        The peak is crossed upwards only while slip grows and downwards only while it falls: anything else is noise and
        does not change a known sign, nor is it the first that is heard of a wheel beyond the peak. A sign -1 that an
        indicator contradicts within its trial was a swing and is withdrawn.

        Args:
            indicator: slope indicator [rad/s^3].
            growing: sign of the slip rate: +1, -1, or 0 where it is not measured.
            slip: returns the slip [-], NaN if unknown; called at a crossing only.
            stamp: time for which the indicator holds [ns].
            trial: time since a sign -1 was told for which nothing may be against it [ns]; 0: nothing is withdrawn.
        """
        if indicator * self.sign < 0.0:
            self.since = stamp
        sign = self._told_by(indicator)
        if self.sign == 0 and (sign > 0 or (sign < 0 and growing > 0)):
            self._tell(sign, stamp)
        elif sign != 0 and sign == -self.sign and growing == -sign:
            self._tell(sign, stamp)
            self.crossings += 1
            self.crossing_sign, self.slip, self.stamp = sign, slip(), stamp
        elif self.sign < 0.0 <= indicator and stamp - self._told < trial:
            self.sign = 0

    def _told_by(self, indicator: float) -> int:
        if indicator < 0.0 and indicator <= self._h_instability:
            return -1
        return 1 if indicator > 0.0 and indicator >= self._h_stability else 0

    def _tell(self, sign: int, stamp: int) -> None:
        self.sign, self.since, self._told = sign, stamp, stamp


class ToldSlips:
    """The largest slip that was surely stable, and the smallest that was surely beyond the peak."""

    def __init__(self) -> None:
        """Begin with none."""
        self.reset()

    def reset(self) -> None:
        """Forget both."""
        self._stable, self._stable_at = -inf, 0
        self._beyond, self._beyond_at = inf, 0

    def tell(self, sign: int, slip: float, stamp: int) -> None:
        """Note a sure sign (+1, -1) at a slip [-], not kept where NaN, and its time [ns]."""
        self._forget_old(stamp)
        if sign > 0:
            if slip >= self._stable:
                self._stable, self._stable_at = slip, stamp
            if slip >= self._beyond:
                self._beyond = inf
        else:
            if slip <= self._beyond:
                self._beyond, self._beyond_at = slip, stamp
            if slip <= self._stable:
                self._stable = -inf

    def cover(self, sign: int, slip: float, stamp: int) -> bool:
        """Whether what was told makes a sign (+1, -1; 0: never) sure at a slip [-] and its time [ns]."""
        self._forget_old(stamp)
        if sign > 0:
            return slip <= NEARER * self._stable
        return sign < 0 and NEARER * slip >= self._beyond

    def _forget_old(self, stamp: int) -> None:
        if stamp - self._stable_at > MEMORY:
            self._stable = -inf
        if stamp - self._beyond_at > MEMORY:
            self._beyond = inf
