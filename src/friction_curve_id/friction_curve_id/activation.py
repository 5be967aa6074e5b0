"""The moment of ABS activation, when the slip first exceeds a threshold, as in Tables 8.4 and 8.5."""

from math import nan
from typing import Final

_ROLLING_SLIP: Final = 0.02
_ROLLING_TIME: Final = 0.5
"""A slip below the first [-] for longer than the second [s] ends the braking."""


class ActivationMark:
    """Watches the slip of one wheel; an activation lasts until the braking ends."""

    def __init__(self, threshold: float) -> None:
        """Mark the first slip above `threshold` [-]."""
        self._threshold = threshold
        self.reset()

    def reset(self) -> None:
        """Forget the activation."""
        self.active = False
        """Whether the slip has passed the threshold in this braking."""
        self.at_activation = False
        """Whether it did so at the latest sample."""
        self.lambda_max = nan
        """Estimate of lambda_max at that moment [-]."""
        self._rolling_since: float | None = None

    def update(self, time: float, slip: float, lambda_max: float) -> None:
        """Take the slip [-] at `time` [s], NaN where unknown, and the estimate of lambda_max [-] with it."""
        self.at_activation = False
        if slip > self._threshold and not self.active:
            self.active, self.at_activation, self.lambda_max = True, True, lambda_max
        if not slip < _ROLLING_SLIP:
            self._rolling_since = None
        elif self._rolling_since is None or time < self._rolling_since:
            self._rolling_since = time
        elif time - self._rolling_since > _ROLLING_TIME:
            self.reset()
