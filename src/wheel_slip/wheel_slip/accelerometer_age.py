"""Delay of the accelerometer relative to the wheels.

An accelerometer that is filtered too much, or whose messages wait somewhere, follows the wheels late. To an estimate of
the speed each change of acceleration then looks like a slide: it integrates what is no longer so. One braking does not
tell a late accelerometer from wheels that slide, several changes do: what the wheels did some tenths of a second ago
explains its readings better than what they do now.

Over windows T the change of the wheels' speed is compared with the integral of the readings, at each of some ages tau:

    r(tau)^2: share of the variance of (integral of a_m from t - T to t) that v_w(t - tau) - v_w(t - tau - T) explains
"""

from collections import deque
from collections.abc import Sequence
from math import isfinite
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.tuning import SlideTuning

_WINDOW: Final = 0.4
"""T [s]."""
_STEP: Final = 0.1
"""[s] between samples that are kept."""
_AGES: Final = (0, 2, 4, 6, 8, 10, 12, 15)
"""[steps] to compare with."""
_LATE_FROM: Final = 4
"""[steps] smaller ages are within what slip and filters do to the comparison, and count as none."""
_STRONGEST: Final = 3.0
"""[m/s^2] changes of the wheels that are compared: in stronger ones they may slide."""
_TELLING: Final = 0.4
"""[m/s^2] changes that tell something."""
_LEAST: Final = 40
"""Windows with such a change, until one may judge: they overlap, and one change of speed has many."""
_REVERSALS: Final = 3
"""Changes between faster and slower until then: in one braking the slip that builds up delays the car as well."""
_MEMORY: Final = 400.0
"""Such windows after which what was counts a third."""
_EXPLAINED: Final = 0.5
"""Share that an age must explain to be that of the accelerometer."""
_UNEXPLAINED: Final = 0.6
"""Largest share of what the present leaves unexplained that it leaves."""
_BACK: Final = 0.9
"""The same for an age that was found: from this share on it is given up."""


class AccelerometerAge:
    """Compares the accelerometer of one car with its wheels. `late` is the age found [s], 0 where it is in time."""

    def __init__(self, parameters: SlideTuning) -> None:
        """Know nothing; the parameters say when wheels turn alike."""
        self._p = parameters
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.late = 0.0
        self._kept: deque[tuple[float, float]] = deque(maxlen=_AGES[-1] + round(_WINDOW / _STEP) + 1)
        self._due = 0
        self._travelled = 0.0
        self._before: tuple[int, float] | None = None
        self._sums = [_Sums() for _ in _AGES]
        self._telling = self._reversals = 0
        self._direction = 0.0

    def update(self, stamp: int, rim_speeds: Sequence[float], acceleration: float) -> None:
        """Take one sample.

        Args:
            stamp: [ns], later than the last.
            rim_speeds: r omega of the wheels [m/s], NaN where unknown.
            acceleration: reading of the accelerometer [m/s^2].
        """
        before, self._before = self._before, (stamp, acceleration)
        if before is None:
            self._due = stamp
        elif stamp - before[0] > _STEP * NANOSECONDS:
            self._kept.clear()
            self._due = stamp
        else:
            self._travelled += 0.5 * (stamp - before[0]) / NANOSECONDS * (before[1] + acceleration)
        if stamp < self._due:
            return
        self._due += round(_STEP * NANOSECONDS)
        known = sorted([speed for speed in rim_speeds if isfinite(speed)])
        if not self._p.are_alike(known):
            self._kept.clear()
            return
        self._kept.append((known[len(known) // 2], self._travelled))
        if len(self._kept) == self._kept.maxlen:
            self._compare()

    def _compare(self) -> None:
        kept, width = self._kept, round(_WINDOW / _STEP)
        changes = [(kept[-1 - age][0] - kept[-1 - age - width][0]) / _WINDOW for age in _AGES]
        if not _TELLING < max(map(abs, changes)) < _STRONGEST:
            return
        measured = (kept[-1][1] - kept[-1 - width][1]) / _WINDOW
        for sums, change in zip(self._sums, changes, strict=True):
            sums.add(change, measured)
        self._telling += 1
        if abs(changes[0]) > _TELLING and changes[0] * self._direction <= 0.0:
            self._reversals += self._direction != 0.0
            self._direction = changes[0]
        if self._telling >= _LEAST and self._reversals >= _REVERSALS:
            self._judge()

    def _judge(self) -> None:
        explained = [sums.explained for sums in self._sums]
        best = max(range(len(_AGES)), key=lambda index: explained[index])
        late = _AGES[best] >= _LATE_FROM and explained[best] > _EXPLAINED
        allowed = _BACK if self.late else _UNEXPLAINED
        in_time = max(share for age, share in zip(_AGES, explained, strict=True) if age < _LATE_FROM)
        late = late and 1.0 - explained[best] < allowed * (1.0 - in_time)
        self.late = _AGES[best] * _STEP if late else 0.0


class _Sums:
    """Of pairs (x, y), the old ones of which fade."""

    def __init__(self) -> None:
        self._n = self._x = self._y = self._xx = self._xy = self._yy = 0.0

    def add(self, x: float, y: float) -> None:
        stay = 1.0 - 1.0 / _MEMORY
        self._n = stay * self._n + 1.0
        self._x = stay * self._x + x
        self._y = stay * self._y + y
        self._xx = stay * self._xx + x * x
        self._xy = stay * self._xy + x * y
        self._yy = stay * self._yy + y * y

    @property
    def explained(self) -> float:
        """Share of the variance of y that x explains; 0 where it goes the other way."""
        xx, yy = self._xx - self._x**2 / self._n, self._yy - self._y**2 / self._n
        xy = self._xy - self._x * self._y / self._n
        return xy * xy / (xx * yy) if xy > 0.0 and xx > 0.0 and yy > 0.0 else 0.0
