"""Deceleration of one wheel from its newest samples, with its standard deviation.

A straight line through the last few samples of the wheel speed.
"""

from math import nan, sqrt
from typing import Final

from sensor_monitor.signal_noise import SignalNoise
from vehicle_models.nanoseconds import NANOSECONDS

WINDOW: Final = 0.035
"""[s] long enough for the noise of a sample, short against a dive of a wheel, which takes 0.1 s."""
_FEWEST: Final = 4
ORDINARY_STDDEV: Final = 0.07
"""[rad/s] of the wheel speed of section 8.3.2, taken before anything is learned."""
_LEAST_STDDEV: Final = 0.02
"""[rad/s] no encoder is better."""


class WheelMotion:
    """Follows one wheel. `update` takes its speed at one stamp after the other."""

    def __init__(self) -> None:
        """Start without samples."""
        self._noise = SignalNoise(ORDINARY_STDDEV**2, _LEAST_STDDEV**2)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._times: list[float] = []
        self._speeds: list[float] = []
        self._noise.reset()
        self._origin: int | None = None
        self.rate = nan
        """[rad/s^2] of the wheel speed over the window; NaN until it is full."""
        self.rate_stddev = nan
        """[rad/s^2]"""

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a sample [rad/s]."""
        return sqrt(self._noise.variance)

    def update(self, stamp: int, wheel_speed: float) -> None:
        """Take the wheel speed [rad/s] at a stamp [ns], later than the last."""
        if self._origin is None:
            self._origin = stamp
        time = (stamp - self._origin) / NANOSECONDS
        times, speeds = self._times, self._speeds
        if times and time - times[-1] > WINDOW:
            times.clear()
            speeds.clear()
        times.append(time)
        speeds.append(wheel_speed)
        while times[0] < time - WINDOW - 1e-6:
            times.pop(0)
            speeds.pop(0)
        self._noise.update(stamp, wheel_speed)
        self._fit()

    def _fit(self) -> None:
        times, speeds = self._times, self._speeds
        count = len(times)
        if count < _FEWEST or times[-1] - times[0] < 0.5 * WINDOW:
            self.rate = self.rate_stddev = nan
            return
        total = spread = moment = 0.0
        for time in times:
            total += time
        mean_time = total / count
        for index in range(count):
            offset = times[index] - mean_time
            spread += offset * offset
            moment += offset * speeds[index]
        self.rate = moment / spread
        self.rate_stddev = sqrt(self._noise.variance / spread)
