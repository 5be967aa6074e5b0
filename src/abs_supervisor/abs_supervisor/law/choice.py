"""Arbitration between the two control laws, with the cause of each change."""

from enum import IntEnum

from vehicle_models.nanoseconds import NANOSECONDS

_WITHOUT_SLIP = round(0.02 * NANOSECONDS)
_WITHOUT_CURVE = round(0.15 * NANOSECONDS)
"""[ns] of braking until the first curve. One that is lost was kept for as long already: to wait once more with the
driver's pressure gave a wheel on snow 600 N m too much, and it locked."""


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


class LawChoice:
    """Chooses for one wheel."""

    def __init__(self) -> None:
        """Start with the curve."""
        self.reset()

    def reset(self) -> None:
        """Start again."""
        self.law = Law.CURVE
        self.cause = Change.NONE
        """Of the last change."""
        self._slip_at: int | None = None
        self._curve_by: int | None = None
        """[ns] from when on the lack of a curve counts: at once where one has been there in this braking."""

    def update(self, stamp: int, braking: bool, slip: bool, curve: bool, explains: bool = True) -> Law:
        """Return the law for a sample.

        Args:
            stamp: [ns], later than the last.
            braking: whether the driver brakes.
            slip: whether it is known.
            curve: whether one is known.
            explains: whether it explains how the wheel moves.
        """
        if slip or self._slip_at is None:
            self._slip_at = stamp
        if braking and curve:
            self._curve_by = stamp
        elif not braking or self._curve_by is None:
            self._curve_by = stamp + _WITHOUT_CURVE
        lost = Change.NONE
        if stamp - self._slip_at >= _WITHOUT_SLIP:
            lost = Change.SLIP_LOST
        elif not explains or (not curve and stamp >= self._curve_by):
            lost = Change.NO_CURVE
        if self.law is Law.CURVE and lost is not Change.NONE:
            self.law, self.cause = Law.SLOPE_SIGN, lost
        elif self.law is Law.SLOPE_SIGN and lost is Change.NONE and slip and (curve or not braking):
            self.law, self.cause = Law.CURVE, Change.RETURNED
        return self.law
