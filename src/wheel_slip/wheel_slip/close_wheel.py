"""Bounds the drift of the integrated speed by the smallest wheel slip within a slide.

A braked wheel is no faster than the car, so a speed that is too high is so by no more than that wheel is behind it. A
tyre that springs back turns its wheel faster than the car for some hundredths of a second, which says nothing: what
counts is the slip s below which the wheel stays for longer, and how small that becomes as its brake cycles:

    c' = s where s < c,    c' = c + min(dt / T (s - c), dt b / v) elsewhere

A slope of the road that the accelerometer does not feel makes the speed wrong by more and more, and all slips with it.
So where c is not what it was a time T into the slide, or later, up or down, the speed may have drifted by as much, but
no faster than on the steepest slope b: a wheel that dives changes c faster. And a wheel that comes closer because the
speed has become too low confirms nothing. On another road a wheel slips by something else: where the accelerometer,
which feels no slope, reads another deceleration than then, and goes on to, c counts anew. What has drifted stays.
"""

from typing import Final

from friction_runtime.filters import SlidingMaximum

_BEGUN: Final = 0.5
"""Of T [-]: time in which the wheel has left the speed."""
_AVERAGED: Final = 0.25
"""Of T [-]: time over which the deceleration is averaged."""
_ANOTHER_ROAD: Final = 0.2
"""Change of it, as a share [-], that is another road's once it lasts: between dry and wet it is 0.31."""
_LASTS: Final = 0.5
"""Of T [-]: longer than wheels that dive and come back take."""


class CloseWheel:
    """The fastest of the braked wheels of a car that agree, during one slide."""

    def __init__(self, close: float, spring_back: float, comes_again: float, steepest: float) -> None:
        """Start without samples.

        Args:
            close: slip below which the wheel confirms the speed, as it slips by anything from 0 to that [-].
            spring_back: time for which it must, as released tyres spring back [s].
            comes_again: T, time within which a wheel whose brake cycles is that close again [s], > 0.
            steepest: b, difference that the slope of a road makes at most [m/s^2].
        """
        self._below, self._spring_back, self._comes_again = close, spring_back, comes_again
        self._steepest = steepest
        self.reset()

    def reset(self) -> None:
        """Forget everything before the next slide."""
        self._slips = SlidingMaximum(self._spring_back)
        self.lasted = 0.0
        """Time that the slide has lasted [s]."""
        self.drift = 0.0
        """By how much the speed may have drifted since it began, as a share of it."""
        self._begin_road()

    def _begin_road(self) -> None:
        self._drifted_before = self.drift
        self._on_road = self._deceleration = self._then = self._other = 0.0
        self._closest = self._least = self._most = 0.0
        self._compared_since: float | None = None

    def update(self, dt: float, slip: float, speed: float, deceleration: float) -> float | None:
        """Take one sample.

        Args:
            dt: time since the last sample [s].
            slip: of the wheel against the integrated speed [-], braking positive.
            speed: of the car [m/s], > 0.
            deceleration: of the car, as measured [m/s^2].

        Returns:
            Standard deviation of the speed, as a share of it, that the wheel leaves; None where it is not close.
        """
        begun = _BEGUN * self._comes_again
        self.lasted += dt
        self._on_road += dt
        averaged = min(self._on_road, _AVERAGED * self._comes_again)
        self._deceleration += dt / averaged * (deceleration - self._deceleration)
        largest = self._slips.update(self.lasted, slip)
        if self.lasted < self._spring_back:
            return None
        stays = max(largest, 0.0)
        if stays < self._closest or self._on_road < begun:
            self._closest = stays
        else:
            self._closest += dt * min((stays - self._closest) / self._comes_again, self._steepest / speed)
        if self._on_road > self._comes_again:
            self._compare(dt, speed)
        return max(stays, self._below - stays, self.drift) if stays < self._below else None

    def _compare(self, dt: float, speed: float) -> None:
        """Compare how close the wheel comes with how close it came."""
        now = self._closest
        if self._compared_since is None:
            self._compared_since, self._least, self._most = self.lasted, now, now
            self._then = self._deceleration
        alike = abs(self._deceleration - self._then) <= _ANOTHER_ROAD * self._then
        self._other = 0.0 if alike else self._other + dt
        if alike:
            self._least, self._most = min(self._least, now), max(self._most, now)
            change = max(now - self._least, self._most - now)
            drift = min(change, self._steepest * (self.lasted - self._compared_since) / speed)
            self.drift = max(drift, self._drifted_before)
        elif self._other > _LASTS * self._comes_again:
            self._begin_road()
