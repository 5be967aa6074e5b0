"""The longest time for which a wheel is locked."""

import numpy as np

from benchmarks.closed_loop.panic_plant import Array, Flags
from benchmarks.protocol import DT

LOCK_TIME = 0.05
"""[s] A wheel is locked if it stands for so long."""
_LOCK_SLIP = 0.95


class LongestLock:
    """Follows n wheels."""

    def __init__(self, count: int, step: float = DT) -> None:
        """Start with none locked; `step` is the time between samples [s]."""
        self._step = step
        self.longest: Array = np.zeros(count)
        """[s], shape (n,)."""
        self._present: Array = np.zeros(count)

    def update(self, slip: Array, counts: Flags) -> None:
        """Take the slips of a sample and for which of them a lock counts, shape (n,)."""
        self._present = np.where(counts & (slip > _LOCK_SLIP), self._present + self._step, 0.0)
        self.longest = np.maximum(self.longest, self._present)
