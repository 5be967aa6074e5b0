"""Noise of the wheel speed as seen while torque and slip are constant: what is stated of a sensor may be too good.

The third difference of a wheel speed that changes smoothly is noise alone; white noise of variance v gives it 20 v.
"""

from collections import deque

import numpy as np

_LEAST = 60
"""Differences without which nothing is known."""
_MEMORY = 200.0
"""Differences over which the mean goes."""
_UNLIKELY = 2.0
"""Ratio to what is stated that chance alone hardly reaches in so many differences."""
_EVEN = 0.1
"""Largest deviation of two steps in time from each other [-]."""
_WHITE = 20.0


class RollingNoise:
    """Takes the samples of one wheel in which nothing moves."""

    def __init__(self, stated: float) -> None:
        """Start with the stated variance [rad^2/s^2], > 0."""
        self._stated = stated
        self._mean, self._count = 0.0, 0
        self.forget_samples()

    @property
    def variance(self) -> float:
        """Variance of the wheel speed [rad^2/s^2]: as seen where that is clearly more than what is stated."""
        seen = self._mean / _WHITE
        return seen if self._count >= _LEAST and seen > _UNLIKELY * self._stated else self._stated

    def forget_samples(self) -> None:
        """Begin anew with the differences; what was seen stays."""
        self._newest: deque[tuple[float, float]] = deque(maxlen=4)

    def update(self, time: float, wheel_speed: float) -> None:
        """Take a sample: time [s] and wheel speed [rad/s]."""
        self._newest.append((time, wheel_speed))
        if len(self._newest) < 4:
            return
        times, speeds = np.array(self._newest).T
        steps = np.diff(times)
        if np.ptp(steps) > _EVEN * steps[0]:
            return
        self._count += 1
        self._mean += (float(np.diff(speeds, 3)[0]) ** 2 - self._mean) / min(self._count, _MEMORY)
