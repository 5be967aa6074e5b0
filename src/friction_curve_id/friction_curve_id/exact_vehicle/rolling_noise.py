"""Noise of the wheel speed as seen while torque and slip are constant: what is stated of a sensor may be too good.

The third difference of a wheel speed that changes smoothly is noise alone; white noise of variance v gives it 20 v.
"""

_LEAST = 60
"""Differences without which nothing is known."""
_MEMORY = 200.0
"""Differences over which the mean goes."""
_UNLIKELY = 2.0
"""Ratio to what is stated that chance alone hardly reaches in so many differences."""
_EVEN = 0.1
"""Largest deviation of two steps in time from each other [-]."""
_SAMPLES = 4
"""With even steps in time, for a third difference."""
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
        self._time = self._step = self._speed = self._first = self._second = 0.0
        self._run = 0

    def update(self, time: float, wheel_speed: float) -> None:
        """Take a sample: time [s] and wheel speed [rad/s]."""
        # In floats: this runs at every sample of ordinary driving.
        step = time - self._time
        first = wheel_speed - self._speed
        second = first - self._first
        third = second - self._second
        if self._run < 2:
            self._run += 1
        else:
            self._run = self._run + 1 if abs(step - self._step) <= _EVEN * step else 2
        if self._run >= _SAMPLES:
            self._count += 1
            self._mean += (third * third - self._mean) / min(self._count, _MEMORY)
        self._time, self._step, self._speed, self._first, self._second = time, step, wheel_speed, first, second
