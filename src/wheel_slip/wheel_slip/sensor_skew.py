"""Delay of the speed sensor relative to the accelerometer, from changes of the acceleration.

Wheels that brake slip by as much as an age of the sensor would make them differ (sensor_age.py); the accelerometer does
not. With T its integral and t_m the stamp of a sample, the age tau_j is that of the sensor where

    sensor(t_m) - T(t_m - tau_j) = delta,    delta' = -b

b is the offset of the accelerometer, which changes with the slope and, by its gain, with the acceleration. For each of
some ages a Kalman filter follows delta and b, and its innovations say how probable the age is; those that no age
explains say nothing. While the car keeps its acceleration all ages are alike. An accelerometer that is late itself
makes the sensor look younger: what both are late by is not seen here.
"""

from collections import deque
from collections.abc import Sequence
from math import exp, log
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

# Its length is left open: compiled, a tuple of ten floats counts as never set.
_AGES: Final[tuple[float, ...]] = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.65, 0.9, 1.2)
"""[s]"""
_STEP: Final = NANOSECONDS // 20
"""Samples nearer to each other than this [ns] say the same."""
_GAP: Final = NANOSECONDS // 2
"""[ns] without a sample after which delta is another one."""
_KEPT: Final = round(1.8 * NANOSECONDS)
"""[ns] for which the integral is kept: the oldest age, and the longest wait for a sample."""
_NOISE: Final = 0.05
"""Deviation of a difference [m/s] beside the noise of the sample: bumps."""
_OFFSET: Final = 0.5
"""Deviation of b before anything is known [m/s^2]: bias, and a slope of 3 %."""
_WALK: Final = 0.1
"""Its change in the square root of a second [m/s^2]: slopes."""
_GAIN: Final = 0.03
"""Its change per change of the acceleration: scale and pitch."""
_NEWS: Final = 0.5
"""Share of a sample that is news: the errors of neighbours are alike."""
_OUTLIER: Final = 4.5
"""Half the squared deviations of an innovation from which on it says nothing: three deviations."""
_TAIL: Final = 1.5
"""Exponent of the ages to expect, 1 / (1 + (tau / deviation)^2): 1 s is one in 300 where the deviation is 0.1 s."""
_MEMORY: Final = 300.0
"""Time [s] after which what was said counts a third."""
_NEGLIGIBLE: Final = 1e-4
"""Probability of an age that is left aside."""
_LEFT: Final = 0.02
"""Deviation of the age that no change of acceleration shows [s]."""
_OLD: Final = 0.2
"""Age [s] from which on a sensor is left out; a younger one is used, with its age in the variance."""
_SURE: Final = 0.99
_UNSURE: Final = 0.5
"""Probabilities of such an age from which on that begins, and down to which it lasts."""


class SensorSkew:
    """Of one speed sensor. `late` is the age with which it is left out [s], 0 where it is not."""

    def __init__(self, stddev: float) -> None:
        """Know nothing but the deviation of the age [s], >= 0."""
        scale = max(stddev, _LEFT)
        self._expected = [-_TAIL * log(1.0 + (age / scale) ** 2) for age in _AGES]
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.late = 0.0
        self._told = [0.0] * len(_AGES)
        self._probabilities = _probabilities(self._expected)
        self.start_again()

    def start_again(self) -> None:
        """Keep the ages, and forget the integral, which begins at another value."""
        self._way: deque[tuple[int, float]] = deque()
        self._newest: tuple[int, float] | None = None
        self._last: int | None = None
        self._acceleration = 0.0
        self._deltas: list[float] = []
        self._offsets: list[float] = []
        self._p = (0.0, 0.0, 0.0)
        """Covariance: of delta, of both, of b."""
        self.spread = 0.0
        """Variance of the newest samples by the ages that are likely [m^2/s^2]."""

    def variance(self, acceleration: float | None) -> float:
        """Variance of a speed by the age of its samples [m^2/s^2], at an acceleration [m/s^2], None if not known."""
        return 0.0 if acceleration is None else self.spread + (_LEFT * acceleration) ** 2

    def follow(self, stamp: int, travelled: float) -> None:
        """Take the integral of the accelerometer's readings [m/s] at a stamp [ns], later than the last."""
        if self._newest is None or stamp - self._newest[0] > _GAP:
            self.start_again()
        self._newest = (stamp, travelled)
        way = self._way
        if not way or stamp - way[-1][0] >= _STEP:
            way.append(self._newest)
            while stamp - way[0][0] > _KEPT:
                way.popleft()
        index, spread = len(way) - 1, 0.0
        for age, probability in zip(_AGES, self._probabilities, strict=True):
            if age and probability > _NEGLIGIBLE:
                while index > 0 and stamp - way[index][0] < age * NANOSECONDS:
                    index -= 1
                spread += probability * (travelled - way[index][1]) ** 2
        self.spread = spread

    def update(self, stamp: int, speed: float, variance: float) -> None:
        """Take a sample.

        Args:
            stamp: of the sample [ns].
            speed: [m/s]
            variance: its noise [m^2/s^2].
        """
        since = None if self._last is None else stamp - self._last
        if since is not None and 0 <= since < _STEP:
            return
        ways = [self._at(stamp - round(age * NANOSECONDS)) for age in _AGES]
        before = self._at(stamp - _STEP)
        differences = [speed - way for way in ways if way is not None]
        if ways[0] is None or before is None or len(differences) < len(_AGES):
            return
        acceleration = (ways[0] - before) / _STEP * NANOSECONDS
        noise = variance + _NOISE**2
        if since is None or not 0 < since < _GAP:
            self._deltas, self._offsets = differences, [0.0] * len(_AGES)
            self._p = (noise, 0.0, _OFFSET**2)
        else:
            self._compare(since / NANOSECONDS, differences, noise, acceleration - self._acceleration)
        self._acceleration, self._last = acceleration, stamp

    def _compare(self, dt: float, differences: list[float], noise: float, change: float) -> None:
        """Say how probable the ages are by the next differences; `change`: of the acceleration [m/s^2]."""
        p11, p12, p22 = self._p
        p11 += dt * (dt * p22 - 2.0 * p12)
        p12 -= dt * p22
        p22 += _WALK**2 * dt + (_GAIN * change) ** 2
        total = p11 + noise
        gain, offset_gain = p11 / total, p12 / total
        self._p = (gain * noise, offset_gain * noise, p22 - offset_gain * p12)
        stay = exp(-dt / _MEMORY)
        for index, difference in enumerate(differences):
            delta = self._deltas[index] - dt * self._offsets[index]
            innovation = difference - delta
            self._deltas[index] = delta + gain * innovation
            self._offsets[index] += offset_gain * innovation
            said = log(exp(-0.5 * innovation**2 / total) + exp(-_OUTLIER))
            self._told[index] = stay * self._told[index] + _NEWS * said
        self._probabilities = _probabilities([a + b for a, b in zip(self._expected, self._told, strict=True)])
        old = sum([each for age, each in zip(_AGES, self._probabilities, strict=True) if age >= _OLD])
        is_late = old > (_UNSURE if self.late else _SURE)
        self.late = self._mean(_AGES) if is_late else 0.0

    def motion(self) -> tuple[float, float, float, float]:
        """Return speed [m/s] and offset b [m/s^2] by the ages that are likely, each followed by its variance.

        They are those at the newest stamp, once `late` has been found.
        """
        stamp, travelled = self._newest or (0, 0.0)
        delta, offset = self._mean(self._deltas), self._mean(self._offsets)
        since = (stamp - (self._last or stamp)) / NANOSECONDS
        of_delta = self._p[0] + self._mean([(each - delta) ** 2 for each in self._deltas])
        of_offset = self._p[2] + self._mean([(each - offset) ** 2 for each in self._offsets])
        return travelled + delta - since * offset, of_delta, offset, of_offset

    def _mean(self, of_ages: Sequence[float]) -> float:
        return sum([each * value for each, value in zip(self._probabilities, of_ages, strict=True)])

    def _at(self, stamp: int) -> float | None:
        """Return the integral at a stamp [ns]; None where that is yet to come, or hardly anything is known.

        Before its first sample the car is taken to have had the acceleration that it then had.
        """
        later, way = self._newest, self._way
        if later is None or stamp > later[0] or len(way) < 2:
            return None
        for known in reversed(way):
            if known[0] <= stamp:
                share = (stamp - known[0]) / (later[0] - known[0]) if later[0] > known[0] else 0.0
                return known[1] + share * (later[1] - known[1])
            later = known
        return way[0][1] + (stamp - way[0][0]) / (way[1][0] - way[0][0]) * (way[1][1] - way[0][1])


def _probabilities(logarithms: Sequence[float]) -> list[float]:
    largest = max(logarithms)
    shares = [exp(each - largest) for each in logarithms]
    total = sum(shares)
    return [each / total for each in shares]
