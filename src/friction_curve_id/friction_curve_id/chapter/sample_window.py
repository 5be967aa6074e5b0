"""The newest friction samples, for the batch methods."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SampleWindow:
    """Holds at most `window` samples, the newest."""

    def __init__(self, window: int = 400) -> None:
        """Start empty."""
        self._points: deque[tuple[float, float]] = deque(maxlen=window)

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin a fit with the first samples, shapes (n,)."""
        self._points.clear()
        self._points.extend(zip(slips.tolist(), frictions.tolist(), strict=True))

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        self._points.append((slip, friction))

    def samples(self) -> tuple[Array, Array]:
        """Slips and frictions, shapes (n,)."""
        slips, frictions = np.array(self._points).T
        return slips, frictions
