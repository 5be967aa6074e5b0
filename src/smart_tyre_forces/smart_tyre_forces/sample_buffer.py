"""The newest samples of a signal, by their indices since the start of the source."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FIRST_SIZE: Final = 4096


class SampleBuffer:
    """Keeps samples in one array, so that to add a block costs what the block costs, not what is kept."""

    def __init__(self, first: int) -> None:
        """Start empty; the next sample has the index `first`."""
        self.first = first
        """Index of the oldest sample that is kept."""
        self._values: Array = np.empty(_FIRST_SIZE)
        self._begin = 0
        self._end = 0

    def __len__(self) -> int:
        """Samples that are kept."""
        return self._end - self._begin

    @property
    def next(self) -> int:
        """Index of the next sample."""
        return self.first + len(self)

    def append(self, values: NDArray[np.floating]) -> None:
        """Take the next samples, shape (n,)."""
        kept, added = len(self), len(values)
        if self._end + added > len(self._values):
            larger = np.empty(max(_FIRST_SIZE, 2 * (kept + added)))
            larger[:kept] = self._values[self._begin : self._end]
            self._values, self._begin, self._end = larger, 0, kept
        self._values[self._end : self._end + added] = values
        self._end += added

    def get(self, first: int, count: int) -> Array:
        """Return `count` samples from index `first` on, shape (count,), all of which are kept: not to be changed."""
        start = self._begin + first - self.first
        return self._values[start : start + count]

    def drop_before(self, index: int) -> None:
        """Keep the samples from an index up to `next` on."""
        surplus = index - self.first
        if surplus > 0:
            self._begin += surplus
            self.first = index
