"""Wheel angle over time from the crossings and the tooth table (section 8.4.4, Figure 8.18c)."""

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.tooth_table import ToothTable, ToothTableLearner

Array = NDArray[np.float64]


class WheelAngle:
    """Angle at each crossing, from the moment the place in the tooth table is known."""

    def __init__(self, teeth: int, table: ToothTable | None = None) -> None:
        """Start; without a table it is learned first."""
        self.table = table
        """Tooth table, None until learned."""
        self.reference = 0
        """Counts the conventions of zero angle: it changes when the old zero could not be found again."""
        self._learner = ToothTableLearner(teeth)
        self.restart()

    def restart(self) -> None:
        """Forget the angle: teeth may have been missed."""
        self.times: Array = np.zeros(0)
        """Times of the crossings whose angle is known [samples], increasing."""
        self.angles: Array = np.zeros(0)
        """Angles at those times [rad], increasing; zero at table index 0 of some revolution."""
        self._waiting: Array = np.zeros(0)
        self._number: int | None = None
        self._learner.restart()

    @property
    def known(self) -> bool:
        """Whether the angle is known."""
        return self._number is not None

    def extend(self, times: Array) -> None:
        """Take the crossings that follow without a fault [samples]."""
        if self._number is None:
            self._waiting = np.concatenate((self._waiting, times))
            times = self._find_place()
            if self._number is None:
                return
        if self.table is not None and self._number is not None and len(times):
            numbers = self._number + np.arange(len(times))
            self._number += len(times)
            self.times = np.concatenate((self.times, times))
            self.angles = np.concatenate((self.angles, self.table.angles(numbers)))

    def time_of(self, angle: float) -> float:
        """Return the time [samples] at which the wheel stood at `angle` [rad], within `angles`."""
        return float(np.interp(angle, self.angles, self.times))

    def at(self, times: Array) -> Array:
        """Return the angle [rad] at `times` [samples] within `self.times`, linear between crossings."""
        return np.asarray(np.interp(times, self.times, self.angles))

    def forget_before(self, time: float) -> None:
        """Drop crossings that lie before `time` [samples], but for one."""
        first = max(int(np.searchsorted(self.times, time)) - 1, 0)
        if first:
            self.times, self.angles = self.times[first:], self.angles[first:]

    def _find_place(self) -> Array:
        """Learn or recognise the table; return the crossings from the place found on."""
        if self.table is None:
            while self.table is None and len(self._waiting) >= self._learner.batch_length:
                batch, self._waiting = np.split(self._waiting, [self._learner.batch_length])
                self.table = self._learner.add(batch)
                if self.table is not None:
                    self._number = 0
                    self.reference += 1
        else:
            while self._number is None and len(self._waiting) >= len(self.table):
                place = self.table.place(self._waiting[: len(self.table)])
                if place is None:
                    self._waiting = self._waiting[len(self.table) :]
                else:
                    self._number = place.index
                    self.reference += not place.certain
        found, self._waiting = (
            (self._waiting, np.zeros(0)) if self._number is not None else (self._waiting, self._waiting)
        )
        return found
