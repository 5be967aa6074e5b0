"""Arbitration between the two control laws, with the cause of each change.

The slope's sign takes over where slip or curve is lost, or where the curve does not explain the wheel: a method that
fits one curve to all wheels has a wrong one for each of them where the sides of the road differ.
"""

from enum import IntEnum
from typing import Final

from abs_supervisor.curve_selector import CURVE_KEPT
from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS

WITHOUT_SLIP: Final = round(0.02 * NANOSECONDS)
"""[ns]"""
EXPLAINED, MISMATCH = 0.35, 0.5
"""[-] disturbance torque over that of the peak: a smaller one is an error of the car, a larger one another road."""
MISMATCH_TIME: Final = round(0.6 * NANOSECONDS)
"""[ns] for which it has to be so. On another road the fit begins anew, and has a curve, in less."""


class Law(IntEnum):
    """The values are those of friction_msgs/SupervisorState."""

    SLOPE_SIGN = 0
    CURVE = 1


class Change(IntEnum):
    """Cause of a change of the law; the values are those of friction_msgs/SupervisorState."""

    NONE = 0
    SLIP_LOST = 1
    NO_CURVE = 2
    RETURNED = 3


class Arbitration:
    """Chooses for one wheel."""

    def __init__(self) -> None:
        """Start with the curve."""
        self._contrary = Debounce(MISMATCH_TIME)
        self.reset()

    def reset(self) -> None:
        """Start again."""
        self.law = Law.CURVE
        self.cause = Change.NONE
        """Of the last change."""
        self._slip_at: int | None = None
        self._curve_by: int | None = None
        """[ns] from when on the lack of a curve counts: at once where one has been there in this braking."""
        self._explains = True
        self._contrary.reset()

    def compare(self, stamp: int, unexplained: float) -> None:
        """Take the size of the disturbance torque over that of the peak [-] at a stamp [ns], later than the last."""
        contrary = unexplained > MISMATCH if self._explains else unexplained < EXPLAINED
        if self._contrary.update(stamp, contrary):
            self._explains = not self._explains
            self._contrary.reset()

    def update(self, stamp: int, braking: bool, slip: bool, curve: bool) -> Law:
        """Return the law for a sample.

        Args:
            stamp: [ns], later than the last.
            braking: whether the driver brakes.
            slip: whether it is known.
            curve: whether one is known.
        """
        if not braking:
            self._explains = True
            self._contrary.reset()
        if slip or self._slip_at is None:
            self._slip_at = stamp
        if braking and curve:
            self._curve_by = stamp
        elif not braking or self._curve_by is None:
            # One that is lost was kept for as long already: a wheel on snow got 600 N m too much meanwhile, and locked.
            self._curve_by = stamp + CURVE_KEPT
        lost = Change.NONE
        if stamp - self._slip_at >= WITHOUT_SLIP:
            lost = Change.SLIP_LOST
        elif not self._explains or (not curve and stamp >= self._curve_by):
            lost = Change.NO_CURVE
        if self.law is Law.CURVE and lost is not Change.NONE:
            self.law, self.cause = Law.SLOPE_SIGN, lost
        elif self.law is Law.SLOPE_SIGN and lost is Change.NONE and slip and (curve or not braking):
            self.law, self.cause = Law.CURVE, Change.RETURNED
        return self.law
