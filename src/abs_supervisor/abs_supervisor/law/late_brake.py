"""Brake delay estimator: additional delay from the own orders and the measured pressure.

Each lateness that may be is a way in which the pressure should have changed from the last sample to this one. The true
one is wrong by noise alone; another is wrong by a whole step wherever rise, hold and fall follow each other. A wrong
rate makes all of them wrong, and the true one least.
"""

from math import isfinite, nan
from typing import Final

from abs_supervisor.law.brake_line import BrakeLine
from vehicle_models.nanoseconds import NANOSECONDS

_STEP: Final = round(0.005 * NANOSECONDS)
_COUNT: Final = 7
"""0 to 30 ms: more is no brake for this law."""
_LONGEST_STEP: Final = round(0.02 * NANOSECONDS)
"""[ns] over a longer gap nothing is learned."""
_MEMORY: Final = 100.0
"""Samples that tell, after which what was seen counts e times less."""
_LEAST_DEVIATION: Final = 5.0
"""[N m] of a change of the pressure from one sample to the next: no sensor is better."""
_SURE: Final = 12.0
"""Logarithm of the likelihood over that of what is believed, from which another lateness is believed."""
_EXPLAINS: Final = 0.5
"""Of the squared changes of the pressure, what it may leave: else the pressure does not follow the orders at all."""


class LateBrake:
    """Follows one brake. `update` takes its measured torque at one sample after the other."""

    def __init__(self, line: BrakeLine) -> None:
        """Choose the brake's orders."""
        self._line = line
        self.reset()

    def reset(self) -> None:
        """Take the brake to be as stated."""
        self.by = 0
        """[ns], 0 to 30 ms."""
        self._wrong = [0.0] * _COUNT
        self._counted = self._changed = 0.0
        self._torque = nan
        self._stamp = 0

    def update(self, stamp: int, torque: float) -> None:
        """Take the measured torque [N m], not finite where it is not known, at a stamp [ns], later than the last."""
        before, last = self._stamp, self._torque
        self._stamp, self._torque = stamp, torque
        if stamp - before > _LONGEST_STEP or not isfinite(torque - last):
            return
        expected = [self._line.torque_at(last, before - _STEP * k, stamp - _STEP * k) for k in range(_COUNT)]
        if max(expected) - min(expected) < _LEAST_DEVIATION:
            return
        kept = 1.0 - 1.0 / _MEMORY
        self._counted = kept * self._counted + 1.0
        self._changed = kept * self._changed + (torque - last) * (torque - last)
        for k in range(_COUNT):
            wrong = torque - expected[k]
            self._wrong[k] = kept * self._wrong[k] + wrong * wrong
        least = min(self._wrong)
        sure = 2.0 * _SURE * max(least / self._counted, _LEAST_DEVIATION * _LEAST_DEVIATION)
        follows = self._changed > sure and least < _EXPLAINS * self._changed
        if follows and self._wrong[self.by // _STEP] - least > sure:
            self.by = self._wrong.index(least) * _STEP
