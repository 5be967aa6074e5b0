"""Unit check: wheels, speed sensor and accelerometer against each other.

A unit does not change on the way. Once the sensors have agreed while the car rolled they are never suspected again, so
no slip of a healthy car passes for a wrong unit.
"""

from collections.abc import Sequence
from math import isfinite, pi
from statistics import median
from typing import Final

from sensor_monitor.acceleration_unit import GENTLE, AccelerationUnit
from vehicle_models.nanoseconds import NANOSECONDS

_ALIKE: Final = 0.03
"""Share by which the speeds of wheels that roll may differ: radii, curves; as `slide.spread`."""
_LOWEST_SPEED: Final = 2.0
"""Lowest speed at the rim at which ratios are judged [m/s]: noise of both sensors is some percent of it."""
_LEAST_AGREEING: Final = 0.7
_MOST_AGREEING: Final = 1.4
"""Ratios of two sensors of one motion lie between [-]: short of the middles to the nearest units, 0.28 and 2.24."""
_NEAR: Final = 0.08
"""Share by which a ratio may miss that of a unit: another tyre, slip. Of units nearer than that all are named."""
_SURE_AFTER: Final = 0.2
"""Time of agreement [s] after which a speed sensor is trusted for good: more than a few wrong samples at 20 Hz."""
_LONGEST_STEP: Final = 0.1
"""Longest time [s] for which one sample counts as agreement."""


class UnitCheck:
    """Compares the sensors of one car while it rolls. `text` names the suspected unit, empty where there is none."""

    def __init__(self, radius: float) -> None:
        """Take the radius of the wheels [m]."""
        self._speeds = (
            (3.6, "vehicle_velocity in km/h"),
            (2.237, "vehicle_velocity in miles an hour"),
            (1.0 / radius, "wheel_states in m/s"),
            (3.6 / radius, "vehicle_velocity in km/h and wheel_states in m/s"),
            (1.0 / 3.6, "wheel_states in km/h"),
            (pi / 30.0, "wheel_states in revolutions a minute"),
            (2.0 * pi, "wheel_states in revolutions a second"),
        )
        self._acceleration = AccelerationUnit()
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self._last: int | None = None
        self._agreed = 0.0
        self._speed_text = ""
        self._acceleration.reset()

    @property
    def text(self) -> str:
        """What is suspected."""
        return self._speed_text or self._acceleration.text

    def update(
        self,
        stamp: int,
        rim_speeds: Sequence[float],
        rim_accelerations: Sequence[float],
        acceleration: float | None,
        measured_speed: float | None,
    ) -> None:
        """Take one sample.

        Args:
            stamp: stamp of the sample [ns].
            rim_speeds: filtered r omega of each wheel [m/s], NaN where unknown.
            rim_accelerations: their rates [m/s^2].
            acceleration: of the accelerometer, forward positive [m/s^2]; None if there is none.
            measured_speed: newest sample of the speed sensor [m/s], None where no new one has come.
        """
        dt = 0.0 if self._last is None else min((stamp - self._last) / NANOSECONDS, _LONGEST_STEP)
        self._last = stamp
        if self._agreed >= _SURE_AFTER:
            measured_speed = None
        if self._acceleration.known:
            acceleration = None
        if measured_speed is None and acceleration is None:
            return
        known = sorted([speed for speed in rim_speeds if isfinite(speed)])
        if not known:
            return
        rim = median(known)
        alike = known[-1] - known[0] <= _ALIKE * rim
        if acceleration is not None and isfinite(acceleration):
            # Neither the wheels of an axle that spins nor one that has failed are this one.
            slower = known[(len(known) - 1) // 2]
            self._acceleration.update(stamp, slower, acceleration, rolling=alike)
        if rim < _LOWEST_SPEED or not alike:
            return
        if measured_speed is not None and abs(median(rim_accelerations)) < GENTLE:
            self._compare_speeds(measured_speed / rim, dt)

    def _compare_speeds(self, ratio: float, dt: float) -> None:
        if _LEAST_AGREEING < ratio < _MOST_AGREEING:
            self._agreed += dt
            self._speed_text = ""
            return
        self._agreed = 0.0
        near = [text for factor, text in self._speeds if abs(ratio / factor - 1.0) < _NEAR]
        if near:
            said = " or ".join(near)
            self._speed_text = f"vehicle_velocity is {ratio:.2f} times the speed of the rolling wheels: {said}?"
