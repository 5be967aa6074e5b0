"""Two-out-of-three consistency check: speed sensor and wheels against the accelerometer.

The sensor differs from the integrated speed and does not from wheels that turn alike. One sample of a sensor says
little; the mean over `_TIME` says what is left of its noise, and what does not average out: radii, and its age.
"""

from math import sqrt
from typing import Final

from friction_runtime.filters import Debounce, first_order_gain
from vehicle_models.nanoseconds import NANOSECONDS

_TIME: Final = 0.5
"""[s] of the mean."""
_SURE: Final = 4.0
"""Standard deviations by which the sensor differs from the integrated speed."""
_ALIKE: Final = 2.0
"""Those within which it agrees with the wheels."""
_LASTS: Final = 0.2
"""[s] for which both must hold."""
_FOR: Final = 30 * NANOSECONDS
"""[ns] for which the accelerometer is left out then."""


class Outvoted:
    """The accelerometer of one car against its speed sensor and its wheels."""

    def __init__(self) -> None:
        """Start without samples."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._until = 0
        self._start_again()

    def _start_again(self) -> None:
        self._last: int | None = None
        self._differs = Debounce(_LASTS * NANOSECONDS)
        self._from_speed = self._from_wheels = self._weight = 0.0

    def holds(self, stamp: int) -> bool:
        """Whether the accelerometer is left out at a stamp [ns]."""
        return stamp < self._until

    def note(
        self, stamp: int, noise: float, from_speed: tuple[float, float], from_wheels: tuple[float, float] | None
    ) -> None:
        """Take a sample of the sensor.

        Args:
            stamp: of the sample [ns].
            noise: variance of the sample [m^2/s^2].
            from_speed: what it differs by from the integrated speed [m/s], and the variance of that speed [m^2/s^2].
            from_wheels: the same for the wheels; None where they do not turn alike.
        """
        if from_wheels is None or (self._last is not None and stamp - self._last > _TIME * NANOSECONDS):
            self._start_again()
        if from_wheels is None:
            return
        dt = _TIME if self._last is None else (stamp - self._last) / NANOSECONDS
        self._last = stamp
        gain = first_order_gain(dt, _TIME)
        self._from_speed += gain * (from_speed[0] - self._from_speed)
        self._from_wheels += gain * (from_wheels[0] - self._from_wheels)
        # Sum of the squared weights of the samples in the mean.
        self._weight = (1.0 - gain) ** 2 * self._weight + gain**2
        left = noise * max(self._weight, gain / (2.0 - gain))
        differs = abs(self._from_speed) > _SURE * sqrt(left + from_speed[1])
        agrees = not abs(self._from_wheels) > _ALIKE * sqrt(left + from_wheels[1])
        if self._differs.update(stamp, differs and agrees):
            self._until = stamp + _FOR
            self._start_again()
