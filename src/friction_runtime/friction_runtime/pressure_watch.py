"""The unit of a wheel's brake pressure, judged at the samples of its speed, refused pressures included."""

from collections import deque
from math import nan
from typing import Final

from vehicle_models.signal_units import PressureUnit
from vehicle_models.vehicle import Vehicle

_KEPT: Final = 100
"""Refused pressures that wait for their sample: 0.5 s at 200 Hz."""


class PressureWatch:
    """Follows one wheel: `refuse` what is no brake pressure as it comes, `judge` at each sample."""

    def __init__(self, vehicle: Vehicle, wheel: str) -> None:
        """Choose a wheel of the car."""
        self._topic = f"{wheel}/brake_pressure"
        self._unit = PressureUnit(vehicle, wheel)
        self._refused: deque[tuple[int, float]] = deque(maxlen=_KEPT)

    @property
    def done(self) -> bool:
        """Whether the unit is known, so that nothing will be suspected any more."""
        return self._unit.known

    def reset(self) -> None:
        """Know nothing of the unit."""
        self._unit.reset()
        self._refused.clear()

    def refuse(self, stamp: int, pressure: float) -> None:
        """Take a pressure [Pa] with stamp [ns] that no brake has."""
        self._refused.append((stamp, pressure))

    def judge(self, stamp: int, wheel_speed: float, pressure: float) -> str:
        """Return what is suspected of the pressure, with its topic, empty where nothing is.

        Args:
            stamp: stamp of the sample [ns].
            wheel_speed: speed of the wheel [rad/s]; not finite where it is missing.
            pressure: pressure at the stamp [Pa], NaN where it is missing.
        """
        if self.done:
            return ""
        refused = nan
        while self._refused and self._refused[0][0] <= stamp:
            _, refused = self._refused.popleft()
        self._unit.update(stamp, wheel_speed, pressure if refused != refused else refused)
        return f"{self._topic}: {self._unit.text}" if self._unit.text else ""
