"""White noise of one signal, by its third differences, which a parabola does not enter.

For white noise of variance R the mean of their square is 20 R.
"""

from collections import deque
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

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
        squared = (d - 3.0 * c + 3.0 * b - a) ** 2 / 20.0
        self.variance += (min(squared, _OUTLIER * self.variance) - self.variance) / _MEMORY
        self.variance = max(self.variance, self._least)
