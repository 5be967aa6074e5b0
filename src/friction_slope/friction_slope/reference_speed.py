"""Vehicle speed for method no_slip, only to detect standstill: a locked wheel must not look like a car at rest."""

from friction_slope.estimate import SlopeSample
from vehicle_models.nanoseconds import NANOSECOND


class ReferenceSpeed:
    """Follows the wheel upwards at once, and downwards no faster than a car can brake."""

    def __init__(self, radius: float, max_deceleration: float) -> None:
        """Start at standstill.

        Args:
            radius: r [m], > 0.
            max_deceleration: hardest braking of any car [m/s^2], > 0.
        """
        self._radius, self._max_deceleration = radius, max_deceleration
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self.speed = 0.0
        """[m/s], at least that of the wheel."""
        self._stamp: int | None = None

    def update(self, sample: SlopeSample) -> None:
        """Take a sample, later than the last."""
        dt = 0.0 if self._stamp is None else (sample.stamp - self._stamp) * NANOSECOND
        self._stamp = sample.stamp
        self.speed = max(sample.wheel_speed * self._radius, self.speed - self._max_deceleration * dt, 0.0)
