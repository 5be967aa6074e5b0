"""Whether wheels, speed sensor and accelerometer speak of one motion in the same units.

A unit does not change on the way. Once the sensors have agreed while the car rolled they are never suspected again, so
no slip of a healthy car passes for a wrong unit.
"""

from collections.abc import Sequence
from math import isfinite, pi
from statistics import median
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_ALIKE: Final = 0.03
"""Share by which the speeds of wheels that roll may differ."""
_LOWEST_SPEED: Final = 2.0
"""Lowest speed at the rim at which ratios are judged [m/s]."""
_GENTLE: Final = 4.0
"""Largest acceleration of wheels that roll [m/s^2]: beyond it their slip counts."""
_LEAST_AGREEING: Final = 0.7
_MOST_AGREEING: Final = 1.4
"""Ratios of two sensors of one motion lie between."""
_NEAR: Final = 0.08
"""Share by which a ratio may miss that of a unit."""
_SURE_AFTER: Final = 0.2
"""Time of agreement after which a speed sensor is trusted for good [s]."""
_MEMORY: Final = 5.0
"""Time over which accelerations are compared [s]."""
_LEAST_TIME: Final = 0.5
"""Least time of driving before they are [s]."""
_LEAST_SPREAD: Final = 0.4
"""Least standard deviation of the wheels' acceleration in that time [m/s^2]."""
_CORRELATED: Final = 0.9
"""Correlation from which two accelerations are those of one motion."""
_LEAST_IN_G: Final = 0.07
_MOST_IN_G: Final = 0.14
"""Ratios between which an acceleration in g lies to one in m/s^2, or one in m/s^2 to that of wheels in revolutions."""


class UnitCheck:
    """Compares the sensors of one car while it rolls. `text` says what is suspected, empty where nothing is."""

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
        self.reset()

    def reset(self) -> None:
        """Know nothing."""
        self._last: int | None = None
        self._agreed = 0.0
        self._speed_text = ""
        self._acceleration_is_known = False
        self._acceleration_text = ""
        self._time = 0.0
        self._mean_wheel = self._mean_sensor = self._wheel = self._sensor = self._both = 0.0

    @property
    def text(self) -> str:
        """What is suspected."""
        return self._speed_text or self._acceleration_text

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
        dt = 0.0 if self._last is None else min((stamp - self._last) / NANOSECONDS, 0.1)
        self._last = stamp
        if self._agreed >= _SURE_AFTER:
            measured_speed = None
        if self._acceleration_is_known:
            acceleration = None
        if measured_speed is None and acceleration is None:
            return
        known = [speed for speed in rim_speeds if isfinite(speed)]
        if not known:
            return
        rim = median(known)
        rate = median(rim_accelerations)
        if rim < _LOWEST_SPEED or max(known) - min(known) > _ALIKE * rim or not abs(rate) < _GENTLE:
            return
        if measured_speed is not None:
            self._compare_speeds(measured_speed / rim, dt)
        if acceleration is not None:
            self._compare_accelerations(rate, acceleration, dt)

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

    def _compare_accelerations(self, wheel: float, sensor: float, dt: float) -> None:
        self._time += dt
        share = min(dt / min(self._time, _MEMORY), 1.0) if self._time > 0.0 else 1.0
        wheel_step, sensor_step = wheel - self._mean_wheel, sensor - self._mean_sensor
        self._mean_wheel += share * wheel_step
        self._mean_sensor += share * sensor_step
        keep = 1.0 - share
        self._wheel = keep * (self._wheel + share * wheel_step * wheel_step)
        self._sensor = keep * (self._sensor + share * sensor_step * sensor_step)
        self._both = keep * (self._both + share * wheel_step * sensor_step)
        if self._time < _LEAST_TIME or self._wheel < _LEAST_SPREAD**2:
            return
        if self._both**2 < _CORRELATED**2 * self._wheel * self._sensor:
            return
        ratio = self._both / self._wheel
        if _LEAST_AGREEING < ratio < _MOST_AGREEING:
            self._acceleration_is_known = True
            self._acceleration_text = ""
        elif _LEAST_AGREEING < -ratio < _MOST_AGREEING:
            self._acceleration_text = "imu/data has the wrong sign against the wheels: forward is positive"
        elif _LEAST_IN_G < ratio < _MOST_IN_G:
            self._acceleration_text = (
                f"imu/data is {ratio:.2f} times the acceleration of the rolling wheels: "
                "in g, or wheel_states in revolutions a minute?"
            )
