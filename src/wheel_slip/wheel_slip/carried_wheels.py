"""Rolling wheel detector: wheels that roll for a moment within a slide.

The gap of a wheel, its rim speed minus the integrated speed of the car, swings while brake and road fight for it, and
stands still when the road carries it alone. Mean m and variance s of the gap are averaged over a time constant T:

    d = gap - m,    m' = m + k d,    s' = s + k (d (gap - m') - s),    k = dt / (T + dt)

A wheel counts as rolling while s stays below quiet * noise variance. A wheel that stands still in a slip looks
the same: whether its gap may be that of a rolling wheel is judged elsewhere (vehicle_speed.py).
"""

from collections.abc import Sequence
from math import isfinite

from wheel_slip.tuning import CarriedTuning


class CarriedWheels:
    """Mean and variance of every wheel's gap during one slide."""

    def __init__(self, parameters: CarriedTuning, count: int, rim_speed_variance: float) -> None:
        """Start empty; `rim_speed_variance`: noise of a rim speed [m^2/s^2]."""
        self._p = parameters
        self._swinging = parameters.swinging**2
        self._count = count
        self.noise = rim_speed_variance
        """Variance of a rim speed [m^2/s^2]."""
        self.reset()

    def reset(self) -> None:
        """Forget everything before the next slide."""
        self._means = [0.0] * self._count
        self._variances = [self._swinging] * self._count

    def update(self, dt: float, rim_speeds: Sequence[float], speed: float) -> list[float]:
        """Take one sample.

        Args:
            dt: time since the last sample [s].
            rim_speeds: r omega of each wheel [m/s], not finite where it is missing.
            speed: integrated speed of the car [m/s].

        Returns:
            Mean gaps of the wheels that are carried [m/s].
        """
        gain, quiet = dt / (self._p.time + dt), self._p.quiet * self.noise
        means, variances = self._means, self._variances
        carried: list[float] = []
        for index, rim_speed in enumerate(rim_speeds):
            if not isfinite(rim_speed):
                variances[index] = self._swinging
                continue
            gap, mean, variance = rim_speed - speed, means[index], variances[index]
            moved = mean + gain * (gap - mean)
            variance += gain * ((gap - mean) * (gap - moved) - variance)
            means[index], variances[index] = moved, variance
            if variance < quiet:
                carried.append(moved)
        return carried

    def gap_variance(self, dt: float) -> float:
        """Noise of a mean gap [m^2/s^2] at sample time `dt` [s]."""
        return self.noise * dt / (2.0 * self._p.time + dt)
