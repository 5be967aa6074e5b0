"""Detection of a change of the road, from the number of surprising wheel speeds among the latest."""

from collections import deque

LONGEST_OUTLIER = 5
"""Most surprises in a row that may be outliers."""


_SURPRISE, _FURTHER_SURPRISE = 4.0, 2.5
"""Innovations beyond these are surprises [standard deviations], the second within a burst of outliers."""


class SurfaceChangeMonitor:
    """Counts surprises among the latest predictions; most of them mean that the road has changed."""

    def __init__(self, needed: int = 8, among: int = 10) -> None:
        """Set how many of the latest `among` predictions must be surprises, `needed` > LONGEST_OUTLIER."""
        self._needed = needed
        self._latest: deque[bool] = deque(maxlen=among)
        self.run = 0
        """Surprises in a row, the newest included."""

    def reset(self) -> None:
        """Forget the latest predictions."""
        self._latest.clear()
        self.run = 0

    def take(self, innovation: float) -> bool:
        """Take the next innovation [standard deviations of the prediction]; return whether it is a surprise."""
        in_burst = 0 < self.run < LONGEST_OUTLIER
        surprising = abs(innovation) > (_FURTHER_SURPRISE if in_burst else _SURPRISE)
        self._latest.append(surprising)
        self.run = self.run + 1 if surprising else 0
        return surprising

    @property
    def changed(self) -> bool:
        """Whether the road has changed."""
        return sum(self._latest) >= self._needed

    @property
    def since(self) -> int:
        """Number of the latest samples that hold the needed surprises: those on the new road."""
        latest = list(self._latest)
        return next((n for n in range(1, len(latest) + 1) if sum(latest[-n:]) >= self._needed), len(latest))
