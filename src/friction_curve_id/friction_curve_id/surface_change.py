"""Detection of a change of the road, from how well each new wheel speed is predicted."""

from collections import deque


class SurfaceChangeMonitor:
    """Counts surprises among the latest predictions.

    The road has changed when most of the latest wheel speeds are far from their predictions. `needed` exceeds the
    longest run of outliers (5) that must not count as a change.
    """

    def __init__(self, threshold: float = 5.0, needed: int = 8, among: int = 10) -> None:
        """Set the surprise threshold [standard deviations], and how many of the latest `among` must exceed it."""
        self._threshold = threshold
        self._needed = needed
        self._latest: deque[bool] = deque(maxlen=among)

    def reset(self) -> None:
        """Forget the latest predictions."""
        self._latest.clear()

    def changed(self, innovation: float) -> bool:
        """Take the next innovation, in standard deviations of the prediction."""
        self._latest.append(abs(innovation) > self._threshold)
        return sum(self._latest) >= self._needed

    @property
    def since(self) -> int:
        """Samples since the first surprise among the latest, that one included."""
        flags = list(self._latest)
        return len(flags) - flags.index(True) if True in flags else 0
