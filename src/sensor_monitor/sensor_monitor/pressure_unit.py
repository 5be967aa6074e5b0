"""Unit of a brake pressure, checked against how its wheel slows down."""

from collections import deque
from math import inf, isfinite, isnan, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_PRESSURE
from vehicle_models.vehicle import Vehicle

_IN_PASCAL: Final = 1e4
"""Pressure that no brake has in bar, psi or MPa, nor any effect in Pa."""
_SURE_AFTER: Final = 5
"""Samples of such a pressure after which its unit is known: one may be a flipped bit."""
_BAR: Final = 1e5
"""[Pa]"""
_LEAST_SPEED_LOSS: Final = 1.0
"""Speed at the rim that a wheel must lose before it is compared [m/s]."""
_LONGEST: Final = 4.0
"""Time in which it must lose it [s]: what slows down less may be rolling out."""
_LONGEST_STEP: Final = 0.1
"""Time between samples from which on they are not compared [s]."""
_LEAST_SHARE: Final = 0.12
_MOST_SHARE: Final = 5.0
"""The pressure of one wheel, taken for that of all, explains a share between these of how fast the wheel slows down:
the least where it dives into lock or brakes less than the others, the most on a road that falls."""
_OTHERS: Final = 20.0
"""In MPa or psi a pressure explains a share that is beyond those by a factor up to this."""
_KEPT: Final = 100
"""Refused pressures that wait for their sample: 0.5 s at 200 Hz."""


class PressureUnit:
    """Follows one wheel. `text` names the suspected unit of its pressure, empty where there is none.

    `refuse` takes what is no brake pressure as it comes, `update` what is one at each sample.
    """

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Choose a wheel of the car."""
        self._radius = vehicle.wheel(wheel).radius
        self._effect = sum(each.brake_gain / each.radius for each in vehicle.wheels) / vehicle.mass
        """Deceleration of the car for the same pressure in all its brakes [m/s^2 / Pa]."""
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self.text = ""
        """What is suspected."""
        self._in_pascal = 0
        self._refused: deque[tuple[int, float]] = deque(maxlen=_KEPT)
        self._last = 0
        self._least = inf
        self._begin(0.0)

    @property
    def known(self) -> bool:
        """Whether pressures have shown to be in Pa: a unit does not change on the way."""
        return self._in_pascal >= _SURE_AFTER

    def refuse(self, stamp: int, pressure: float) -> None:
        """Take a pressure [Pa] with stamp [ns] that no brake has."""
        self._refused.append((stamp, pressure))

    def update(self, stamp: int, wheel_speed: float, pressure: float) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            wheel_speed: speed of the wheel [rad/s]; not finite where it is missing.
            pressure: pressure of its brake [Pa], also one that no brake has; not finite where it is missing.
        """
        if self.known:
            return
        refused = nan
        while self._refused and self._refused[0][0] <= stamp:
            _, refused = self._refused.popleft()
        if not isnan(refused):
            pressure = refused
        self._count(abs(pressure))
        if self.known:
            self.text = ""
            return
        speed = abs(wheel_speed) * self._radius
        if not (isfinite(speed) and isfinite(pressure)):
            return
        self._least = min(self._least, pressure)
        step = (stamp - self._last) / NANOSECONDS
        self._last = stamp
        if not 0.0 < step <= _LONGEST_STEP or speed >= self._from or self._time > _LONGEST:
            self._begin(speed)
            return
        self._time += step
        self._impulse += step * (pressure - self._least)
        lost = self._from - speed
        if lost >= _LEAST_SPEED_LOSS:
            self._judge(lost / self._time, self._effect * self._impulse / lost)
            self._begin(speed)

    def _count(self, pressure: float) -> None:
        if _IN_PASCAL < pressure <= HIGHEST_PRESSURE:
            self._in_pascal += 1
        elif pressure > HIGHEST_PRESSURE:
            self._in_pascal = max(self._in_pascal - 1, 0)

    def _begin(self, speed: float) -> None:
        """Compare from this speed at the rim on [m/s]."""
        self._from = speed
        self._time = self._impulse = 0.0

    def _judge(self, deceleration: float, share: float) -> None:
        said = f"brakes {share:.1g} times as much as its wheel slows down, by {deceleration:.1f} m/s^2"
        if _LEAST_SHARE < share * _BAR < _MOST_SHARE:
            self.text = f"{said}: in bar?"
        elif _LEAST_SHARE < share / _BAR < _MOST_SHARE:
            self.text = f"{said}: in Pa, and converted from bar once more?"
        elif not self.text and _LEAST_SHARE / _OTHERS < share * _BAR < _MOST_SHARE * _OTHERS:
            self.text = f"{said}: in MPa or psi?"
