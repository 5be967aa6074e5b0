"""Memory of slips with a confident slope sign, used while the sign is unknown.

A friction curve has one peak: a wheel below a slip that was surely stable is stable, one above a slip that was surely
beyond the peak is beyond it. Another road has another curve, so what was told is soon forgotten, and a contradiction
makes it forgotten at once.
"""

from math import inf
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

MEMORY: Final = round(1.0 * NANOSECONDS)
"""Time for which a told slip counts [ns]."""
NEARER: Final = 0.8
"""Share that a slip must keep to, of one that was told: for the errors of slip."""


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
