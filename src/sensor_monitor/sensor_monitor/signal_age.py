"""Age of one signal of motion against another, and the probability that an accelerometer is turned or stuck.

With X the later signal and Y the earlier one (speeds, or an acceleration integrated), the age tau_j of X is that where

    X(t) - Y(t - tau_j) = delta,    delta' = b

b is the offset of the accelerometer with the slope of the road. For each of some ages a Kalman filter follows delta and
b, and its innovations say how probable the age is. Two more hypotheses serve an accelerometer: X has the wrong sign; X
says nothing, and Y changes as cars do. An innovation that no hypothesis explains says nothing, and a single braking
little: wheels that slip delay the car as well. While the car keeps its acceleration all ages are alike.
"""

from collections import deque
from math import exp
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.nanoseconds import NANOSECONDS

Array = NDArray[np.float64]

_AGES: Final = np.array([0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.65, 0.9, 1.2, 1.5])
"""Ages that are compared [s]."""
_TURNED, _STUCK = len(_AGES), len(_AGES) + 1
_STEP: Final = NANOSECONDS // 20
"""Samples nearer to each other than this [ns] say the same."""
_GAP: Final = NANOSECONDS // 2
"""[ns] without a sample after which delta is another one."""
_NOISE: Final = 0.05
"""Deviation of a difference beside the stated noise [m/s]: bumps."""
_OFFSET: Final = 0.5
"""Deviation of b before anything is known [m/s^2]: bias, and a slope of 3 %."""
_WALK: Final = 0.1
"""Its change in the square root of a second [m/s^2]: slopes."""
_MOTION: Final = 3.0
"""The same for a car whose acceleration is not known [m/s^2]."""
_GAIN: Final = 0.03
"""Its change per change of the acceleration: scale and pitch."""
_NEWS: Final = 0.5
"""Share of a sample that is news: the errors of neighbours are alike."""
_OUTLIER: Final = 4.5
"""Half the squared deviations of an innovation from which on it says nothing: three deviations."""
_TAIL: Final = 1.5
"""Exponent of the ages to expect, 1 / (1 + (tau / deviation)^2): 1 s is one in 300 where the deviation is 0.1 s."""
_FAULTY: Final = 1e-3
"""Probability that an accelerometer is turned, and that it is stuck."""
_MEMORY: Final = 300.0
"""Time after which what was said counts a third [s]."""
_OLD: Final = 0.2
"""Age from which on a signal is of no use [s]; a younger one is used, with its age in the variance."""
_SURE: Final = 0.99
_UNSURE: Final = 0.5
"""Probabilities of being of no use from which on that is named, and down to which it lasts."""


class SignalAge:
    """Of one signal X against an earlier one Y."""

    def __init__(self, deviation: float, accelerometer: bool) -> None:
        """Know nothing.

        Args:
            deviation: of the age to expect [s], > 0.
            accelerometer: whether X is the integral of an accelerometer, which may be turned or stuck.
        """
        count = _AGES.size + 2
        self._expected = np.full(count, np.log(_FAULTY) if accelerometer else -1e3)
        self._expected[: _AGES.size] = -_TAIL * np.log1p((_AGES / deviation) ** 2)
        self._sign = np.ones(count)
        self._sign[[_TURNED, _STUCK]] = -1.0, 0.0
        self._walk = np.full(count, _WALK**2)
        self._walk[_STUCK] = _MOTION**2
        self._ages = np.concatenate([_AGES, [0.0, 0.0]])
        self._useless = (self._ages >= _OLD) | (self._sign < 1.0)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._told = np.zeros(self._ages.size)
        self._is_useless = False
        self._weigh()
        self.start_again()

    def start_again(self) -> None:
        """Keep what was said, and forget the signals, which begin at other values."""
        self._way: deque[tuple[int, float]] = deque(maxlen=40)
        self._delta: Array | None = None
        self._last = 0
        self._rate = 0.0

    def follow(self, stamp: int, value: float) -> None:
        """Take Y [m/s] at a stamp [ns]."""
        if self._way and stamp - self._way[-1][0] > _GAP:
            self._way.clear()
            self._delta = None
        if not self._way or stamp - self._way[-1][0] >= _STEP:
            self._way.append((stamp, value))

    def compare(self, stamp: int, value: float, rate: float, variance: float, drift: float = 0.0) -> None:
        """Say how probable the hypotheses are by X.

        Args:
            stamp: of the sample [ns].
            value: X [m/s].
            rate: acceleration at that time as far as the accelerometer tells it [m/s^2].
            variance: of the difference [m^2/s^2]: noise, and what slip does to it.
            drift: variance that comes to it in a second [m^2/s^3]: the noise of an accelerometer, integrated.
        """
        since = stamp - self._last
        if 0 <= since < _STEP or len(self._way) < 2:
            return
        if stamp > self._way[-1][0] + _STEP or stamp - _AGES[-1] * NANOSECONDS < self._way[0][0]:
            return
        differences = self._sign * value - self._aged(stamp)
        noise = variance + _NOISE**2
        if self._delta is None or not 0 < since < _GAP:
            self._delta, self._b = differences, np.zeros(differences.size)
            self._p11, self._p12, self._p22 = noise + self._walk, 0.0 * self._walk, _OFFSET**2 + self._walk
        else:
            self._correct(since / NANOSECONDS, differences, noise, rate - self._rate, drift)
        self._rate, self._last = rate, stamp

    def _correct(self, dt: float, differences: Array, noise: float, change: float, drift: float) -> None:
        assert self._delta is not None
        p11 = self._p11 + dt * (drift + 2.0 * self._p12 + dt * self._p22)
        p12 = self._p12 + dt * self._p22
        p22 = self._p22 + self._walk * dt + (_GAIN * change) ** 2
        innovation = differences - (self._delta + dt * self._b)
        total = p11 + noise
        self._delta = differences - innovation * noise / total
        self._b = self._b + p12 / total * innovation
        self._p11, self._p12, self._p22 = p11 * noise / total, p12 * noise / total, p22 - p12**2 / total
        likelihood = np.exp(-0.5 * innovation**2 / total) + exp(-_OUTLIER)
        self._told = exp(-dt / _MEMORY) * self._told + _NEWS * (np.log(likelihood) - 0.5 * np.log(total))
        self._told -= self._told.max()
        self._weigh()

    def _weigh(self) -> None:
        weights = self._expected + self._told
        weights = np.exp(weights - weights.max())
        self.probabilities = weights / weights.sum()
        """Of the ages, of a turned and of a stuck signal, shape (13,)."""
        self.wrong = float(self.probabilities[self._useless].sum())
        """Probability that the signal is of no use."""
        self._is_useless = self.wrong > (_UNSURE if self._is_useless else _SURE)

    @property
    def age_variance(self) -> float:
        """Mean square of the age as far as it is of use [s^2]."""
        young = np.where(self._useless, 0.0, self.probabilities)
        return float(young @ self._ages**2)

    def moved(self, stamp: int) -> tuple[float, float]:
        """Change of Y within the age of X at a stamp [ns]: its mean [m/s] and its variance [m^2/s^2]."""
        if len(self._way) < 2:
            return 0.0, 0.0
        aged = self._aged(stamp)
        moved = aged[0] - aged
        mean = float(self.probabilities @ moved)
        return mean, float(self.probabilities @ (moved - mean) ** 2)

    def _aged(self, stamp: int) -> Array:
        """Return Y [m/s] at each of the ages before a stamp [ns]."""
        stamps, values = np.array(self._way).T
        return np.interp(stamp - self._ages * NANOSECONDS, stamps, values)

    @property
    def late(self) -> float:
        """Mean age of the signal as far as it is of no use [s]."""
        return float(np.where(self._useless, self.probabilities, 0.0) @ self._ages) / self.wrong

    @property
    def text(self) -> str:
        """Names what is wrong, empty where the signal is of use."""
        if not self._is_useless:
            return ""
        if self.probabilities[_TURNED] > 0.5 * self.wrong:
            return "has the wrong sign"
        if self.probabilities[_STUCK] > 0.5 * self.wrong:
            return "says nothing of the motion"
        return f"some {self.late:.1f} s late"
