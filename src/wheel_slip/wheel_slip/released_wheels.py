"""Released wheels: a wheel whose brake opened within a slide measures the speed once it rolls.

Without its brake a wheel comes back to the speed of the car, and once its tyre has sprung back it stays there. Its rim
has gained speed as the pressure fell, then keeps its gap to the integrated speed, and no other wheel is faster: that
tells a brake that is open from a pressure sensor that only says so. Neither road nor accelerometer is in it, so it is
the one witness of a slope that began during the slide.
"""

from collections import deque
from collections.abc import Sequence
from math import inf, isfinite, sqrt
from typing import Final

from wheel_slip.tuning import ReleasedTuning

_CLOSED: Final = 2.0
"""Of `open_below`: a brake that has had as much was closed."""
_NOISE: Final = 4.0
"""Deviations of a rim speed by which a gap that stands may seem to swing."""
_COMES_BACK: Final = 0.3
"""[s] within which a wheel comes back."""
_FEWEST: Final = 3
"""Samples of a gap that stands."""


class ReleasedWheels:
    """The wheels of one car."""

    def __init__(self, parameters: ReleasedTuning, count: int) -> None:
        """Start with `count` wheels of whose brakes nothing is known."""
        self._p = parameters
        self._wheels = [_ReleasedWheel(parameters) for _ in range(count)]

    def reset(self) -> None:
        """Know nothing of any brake."""
        for wheel in self._wheels:
            wheel.reset()

    def update(
        self, dt: float, torques: Sequence[float], rim_speeds: Sequence[float], speed: float, noise: float
    ) -> float | None:
        """Take one sample.

        Args:
            dt: time since the last [s].
            torques: of the brakes [N m], NaN where unknown.
            rim_speeds: r omega of each wheel [m/s], NaN where unknown.
            speed: of the car [m/s], > 0.
            noise: variance of a rim speed [m^2/s^2].

        Returns:
            The gap of a wheel that has been released and turns with the car [m/s], once a release; None elsewhere.
        """
        steady = self._p.swings * speed + _NOISE * sqrt(noise)
        found, fastest = -inf, -inf
        for wheel, torque, rim_speed in zip(self._wheels, torques, rim_speeds, strict=True):
            gap = rim_speed - speed
            told = wheel.update(dt, torque, gap, speed, steady)
            if told is not None:
                found = max(found, told)
            if isfinite(gap):
                fastest = max(fastest, gap)
        return found if isfinite(found) and found > fastest - steady else None


class _ReleasedWheel:
    """Brake and gap of one of them."""

    def __init__(self, parameters: ReleasedTuning) -> None:
        self._p = parameters
        self.reset()

    def reset(self) -> None:
        self._was_closed = False
        self._lowest = inf
        self._open_for = 0.0
        self._gaps: deque[tuple[float, float]] = deque()

    def update(self, dt: float, torque: float, gap: float, speed: float, steady: float) -> float | None:
        """Return its mean gap [m/s] at the first sample at which it turns with the car after a release."""
        if not isfinite(torque + gap):
            self.reset()
            return None
        p, lowest, gaps = self._p, self._lowest, self._gaps
        self._lowest = gap if gap < lowest else lowest + min(dt / _COMES_BACK, 1.0) * (gap - lowest)
        if torque > p.open_below:
            self._was_closed = self._was_closed or torque > _CLOSED * p.open_below
            self._open_for = 0.0
            gaps.clear()
            return None
        if not self._was_closed:
            return None
        self._open_for += dt
        gaps.append((self._open_for, gap))
        while len(gaps) > _FEWEST and self._open_for - gaps[1][0] >= p.stands:
            gaps.popleft()
        if self._open_for < p.settles or len(gaps) < _FEWEST:
            return None
        known = [each for _, each in gaps]
        mean = sum(known) / len(known)
        if max(known) - min(known) > steady or mean - self._lowest < p.gained * speed:
            return None
        self._was_closed = False
        return mean
