"""Delay of the speed sensor relative to the undriven wheels while the engine pulls.

A speed of a satellite receiver is some tenths of a second old, one that a logger writes into every row until the next
one comes is older. While the car keeps its speed nothing shows that. With the mean rim speed w of the wheels that the
engine does not drive and their acceleration a, at the time of a sample's stamp

    sensor - w = s w - tau a + noise

s, what the radii have in common, does not change within minutes, so that it is not taken for an age tau. Braked and
driven wheels slip by as much as an age would make them differ: only free ones tell, while the road makes them faster.
"""

from collections import deque
from math import sqrt
from typing import Final, NamedTuple

from friction_runtime.filters import Debounce
from vehicle_models.nanoseconds import NANOSECONDS

_STEP: Final = NANOSECONDS // 10
"""Samples nearer to each other than this [ns] say the same."""
_KEPT: Final = 5
"""Samples over which the acceleration is taken."""
_GENTLE: Final = 0.5
_STRONGEST: Final = 3.0
"""[m/s^2] between which the road makes wheels faster: below it tells little, above a brake may have been released."""
_UNLIKE: Final = 0.05
_OLDEST: Final = round(2.5 * NANOSECONDS)
"""Where the speed has hardly changed for this time [ns], neither radii nor age make a sensor differ by this share."""
_NOISE: Final = 0.3
"""Deviation of such a difference [m/s], beside the noise of the sample: curves, bumps, the filters of the wheels."""
_SHARE: Final = 0.02
_AGE_STDDEV: Final = 1.0
"""Deviations of s, and of tau [s], before anything is known."""
_SHARE_WALK: Final = 1e-4
_AGE_WALK: Final = 1e-2
"""By which they change in the square root of a second."""
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
        self._share = self._age = 0.0
        self._p = (_SHARE**2, 0.0, _AGE_STDDEV**2)
        """Covariance: of s, of both, of tau."""
        self._kept: deque[_Sample] = deque(maxlen=_KEPT)
        self._taken: int | None = None
        self._acceleration = 0.0
        self._is_wrong = False
        self._gentle = Debounce()
        self._is_first = True

    @property
    def error(self) -> float:
        """Error of the newest samples by an age that is likely and not known [m/s]; at first what they differ by."""
        if self._is_first:
            return abs(self._kept[-1].difference) if self._kept else 0.0
        return abs(self._age * self._acceleration) if self._age > _LIKELY * sqrt(self._p[2]) else 0.0

    def update(self, stamp: int, difference: float, rim_speed: float, variance: float) -> None:
        """Take a sample, and free wheels that turn alike at its time.

        Args:
            stamp: of the sample [ns].
            difference: sensor minus wheels [m/s].
            rim_speed: of the wheels [m/s].
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
        self._gentle.update(stamp, not abs(a) >= _GENTLE)
        if self._gentle.elapsed(stamp) > _OLDEST:
            self._is_wrong = abs(middle.difference) > _UNLIKE * middle.rim_speed
        if _GENTLE < a < _STRONGEST and not self._is_wrong:
            self._correct(middle, a)
            self._judge()

    def _correct(self, sample: "_Sample", acceleration: float) -> None:
        seconds = 0.0 if self._taken is None else min((sample.stamp - self._taken) / NANOSECONDS, 1.0)
        self._taken = sample.stamp
        of_share, of_both, of_age = self._p
        of_share += _SHARE_WALK**2 * seconds
        of_age += _AGE_WALK**2 * seconds
        w = sample.rim_speed
        to_share, to_age = of_share * w - of_both * acceleration, of_both * w - of_age * acceleration
        of_all = w * to_share - acceleration * to_age + _NOISE**2 + sample.variance
        innovation = sample.difference - w * self._share + acceleration * self._age
        self._share += to_share / of_all * innovation
        self._age += to_age / of_all * innovation
        self._p = (
            of_share - to_share**2 / of_all,
            of_both - to_share * to_age / of_all,
            of_age - to_age**2 / of_all,
        )

    def _judge(self) -> None:
        deviation = sqrt(self._p[2])
        if self._age > max(_LATE, _SURE * deviation):
            self.late = self._age
        elif self._age < max(0.5 * _LATE, _LIKELY * deviation):
            self.late = 0.0


class _Sample(NamedTuple):
    """One of the sensor, and the wheels at its time."""

    stamp: int
    difference: float
    rim_speed: float
    variance: float
