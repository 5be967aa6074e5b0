"""Order of the stamps of a fit."""

from enum import Enum
from typing import Final

from friction_curve_id.interface import Refusal
from vehicle_models.reason import Reason

_REPEATED: Final = 1e-4
"""Samples closer than this count as repeated [s]."""


class Admission(Enum):
    """How an admitted sample follows the ones before it."""

    FIRST = "first"
    NEXT = "next"
    AFTER_GAP = "after a gap"


class StampOrder:
    """Admits stamps one by one.

    After a gap, or a jump back in time, the first sample is refused; the one that continues it is admitted as
    `AFTER_GAP`, so that a single wrong stamp costs one sample and never the fit. A stamp that repeats the last admitted
    one continues nothing, whatever came between: it is the same message again.
    """

    def __init__(self, max_gap: float) -> None:
        """Admit samples that are at most `max_gap` [s] apart."""
        self._max_gap = max_gap
        self.reset()

    def reset(self) -> None:
        """Forget the stamps seen."""
        self._admitted: float | None = None
        self._waiting: float | None = None

    def admit(self, time: float) -> Admission | Refusal:
        """Return how a sample at `time` [s], finite, follows the admitted ones, or why it must not enter."""
        last, waiting = self._admitted, self._waiting
        if last is None:
            admission = Admission.FIRST
        elif self._follows(last, time):
            admission = Admission.NEXT
        elif abs(time - last) < _REPEATED:
            return Refusal(Reason.BAD_INPUT, f"stamp {time:.6f} s repeats {last:.6f} s")
        elif waiting is not None and self._follows(waiting, time):
            admission = Admission.AFTER_GAP
        else:
            self._waiting = time
            if time < last:
                return Refusal(Reason.GAP, f"stamp {time:.6f} s is before the last, {last:.6f} s")
            return Refusal(Reason.GAP, f"gap of {time - last:.3f} s since the last sample")
        self._admitted, self._waiting = time, None
        return admission

    def _follows(self, before: float, time: float) -> bool:
        return _REPEATED <= time - before <= self._max_gap
