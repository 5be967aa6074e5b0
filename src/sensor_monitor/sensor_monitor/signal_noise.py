"""White noise of a signal, by its third differences, which a parabola does not enter.

For white noise of variance R the mean of their square is 20 R. SignalNoise follows a signal, white_noise takes samples
that are there.
"""

from collections import deque
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.nanoseconds import NANOSECONDS

_SQUARE: Final = 20.0
_MEDIAN: Final = 0.6745
"""Median of the size of what is normally distributed, over its standard deviation."""
_MEMORY: Final = 100.0
"""Samples over which the noise is averaged."""
_OUTLIER: Final = 16.0
"""A squared third difference counts for at most so many times its mean: it is a jump, not noise."""
MORE: Final = 9.0
"""Times the expected variance from which on what is seen counts in its place."""
_UNEVEN: Final = 0.2
"""Sample times that differ by more than this share do not give a third difference."""


class SignalNoise:
    """Of one signal. `variance` is that of a sample, in the square of its unit."""

    def __init__(self, ordinary: float, least: float) -> None:
        """Start with an ordinary variance; none is taken to be less than `least`."""
        self._ordinary, self._least = ordinary, least
        self.reset()

    def reset(self) -> None:
        """Know what is ordinary."""
        self.variance = self._ordinary
        self._samples: deque[tuple[int, float]] = deque(maxlen=4)

    @property
    def drift(self) -> float:
        """Variance of the integral of the noise in a second, in the square of the unit times s."""
        if len(self._samples) < 2:
            return 0.0
        return self.variance * (self._samples[-1][0] - self._samples[-2][0]) / NANOSECONDS

    def update(self, stamp: int, value: float) -> None:
        """Take a sample at a stamp [ns], later than the last."""
        self._samples.append((stamp, value))
        if len(self._samples) < 4:
            return
        (ta, a), (tb, b), (tc, c), (td, d) = self._samples
        longest, shortest = max(tb - ta, tc - tb, td - tc), min(tb - ta, tc - tb, td - tc)
        if longest - shortest > _UNEVEN * longest:
            return
        squared = (d - 3.0 * c + 3.0 * b - a) ** 2 / _SQUARE
        self.variance += (min(squared, _OUTLIER * self.variance) - self.variance) / _MEMORY
        self.variance = max(self.variance, self._least)


def white_noise(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the standard deviation of the noise of signals, shape (W,), in their unit.

    By the median: what is not noise in less than half of the samples does not count.

    Args:
        samples: at even times, shape (W, n), n >= 4.
    """
    return np.asarray(np.median(np.abs(np.diff(samples, 3)), axis=1) / (_MEDIAN * sqrt(_SQUARE)))
