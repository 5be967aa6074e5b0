"""How old the samples of the speed sensor are: what it differs by from wheels that roll grows with the acceleration.

A speed of a satellite receiver is some tenths of a second old, one that a logger writes into every row until the next
one comes is older. While the car keeps its speed nothing shows that. With the mean rim speed w of the wheels, the
deceleration d by which their tyres slip and the acceleration a, at the time of a sample's stamp

    sensor - w = s w + c d w - tau a + noise

s, what the radii have in common, and c, the slip of rolling wheels, do not change within minutes, so that they are
never taken for an age tau: on one braking at one speed, c and tau are the same, and the deviation of tau says so.
"""

from collections import deque
from math import sqrt
from typing import Final, NamedTuple

from vehicle_models.nanoseconds import NANOSECONDS

_STEP: Final = NANOSECONDS // 10
"""Samples nearer to each other than this [ns] say the same."""
_KEPT: Final = 5
"""Samples over which the acceleration is taken."""
_STRONGEST: Final = 3.0
"""[m/s^2] changes of the wheels that are compared: in stronger ones they may slide, or spring back."""
_GENTLE: Final = 0.5
_UNLIKE: Final = 0.05
"""In changes below the one [m/s^2] neither radii, slip nor age make a sensor differ by the other, as a share."""
_NOISE: Final = 0.3
"""Deviation of such a difference [m/s], beside the noise of the sample: curves, bumps, the filters of the wheels."""
_SHARE: Final = 0.02
"""That of s, at least."""
_SLIP: Final = 0.008
_SLIP_STDDEV: Final = 0.03
"""c [s^2/m] to expect, and its deviation."""
_AGE_STDDEV: Final = 1.0
"""That of tau [s]."""
_WALK: Final = (1e-4, 2e-3, 1e-2)
"""By which s, c and tau [s] change in the square root of a second."""
_LATE: Final = 0.25
"""[s] younger samples are used, with their age in the variance."""
_SURE: Final = 3.5
_LIKELY: Final = 1.5
"""Standard deviations of tau from which on it is one that is known, and one that may be."""


class SensorAge:
    """Of one speed sensor. `late` is the age that is known [s], 0 where it is none to speak of."""

    def __init__(self) -> None:
        """Know nothing."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.late = 0.0
        self._state = [0.0, _SLIP, 0.0]
        self._p = [[_SHARE**2, 0.0, 0.0], [0.0, _SLIP_STDDEV**2, 0.0], [0.0, 0.0, _AGE_STDDEV**2]]
        self._kept: deque[_Sample] = deque(maxlen=_KEPT)
        self._taken = 0
        self._acceleration = 0.0
        self._is_wrong = False
        self._is_first = True

    @property
    def error(self) -> float:
        """Error of the newest samples by an age that is likely and not known [m/s]; at first what they differ by."""
        if self._is_first:
            return abs(self._kept[-1].difference) if self._kept else 0.0
        age = self._state[2]
        return abs(age * self._acceleration) if age > _LIKELY * sqrt(self._p[2][2]) else 0.0

    def update(self, stamp: int, difference: float, rim_speed: float, free: bool, variance: float) -> None:
        """Take a sample, and wheels that turn alike at its time.

        Args:
            stamp: of the sample [ns].
            difference: sensor minus wheels [m/s].
            rim_speed: of the wheels [m/s].
            free: whether no engine drives them.
            variance: noise of the sample [m^2/s^2].
        """
        kept = self._kept
        if kept:
            since = stamp - kept[-1].stamp
            if 0 <= since < _STEP:
                return
            if not 0 <= since < 3 * _STEP:
                kept.clear()
        kept.append(_Sample(stamp, difference, rim_speed, variance))
        if len(kept) < _KEPT:
            return
        self._is_first = False
        self._acceleration = a = (rim_speed - kept[0].rim_speed) / (stamp - kept[0].stamp) * NANOSECONDS
        middle = kept[_KEPT // 2]
        if abs(a) < _GENTLE:
            self._is_wrong = abs(middle.difference) > _UNLIKE * middle.rim_speed
        if self._is_wrong or abs(a) > _STRONGEST:
            return
        self._correct(middle, 0.0 if free and a > 0.0 else -a)
        self._judge()

    def _correct(self, sample: "_Sample", effort: float) -> None:
        seconds = min((sample.stamp - self._taken) / NANOSECONDS, 1.0) if self._taken else 0.0
        self._taken = sample.stamp
        p, row = self._p, (sample.rim_speed, effort * sample.rim_speed, -self._acceleration)
        for i in range(3):
            p[i][i] += _WALK[i] ** 2 * seconds
        column = [p[i][0] * row[0] + p[i][1] * row[1] + p[i][2] * row[2] for i in range(3)]
        expected = sum([row[i] * self._state[i] for i in range(3)])
        of_all = sum([row[i] * column[i] for i in range(3)]) + _NOISE**2 + sample.variance
        for i in range(3):
            self._state[i] += column[i] / of_all * (sample.difference - expected)
        self._p = [[p[i][j] - column[i] * column[j] / of_all for j in range(3)] for i in range(3)]

    def _judge(self) -> None:
        age, deviation = self._state[2], sqrt(self._p[2][2])
        if age > _LATE and age > _SURE * deviation:
            self.late = age
        elif age < 0.5 * _LATE or age < _LIKELY * deviation:
            self.late = 0.0


class _Sample(NamedTuple):
    """One of the sensor, and the wheels at its time."""

    stamp: int
    difference: float
    rim_speed: float
    variance: float
