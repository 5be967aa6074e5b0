"""Deceleration of the car from brake pressures and wheel speeds alone.

The force of each tyre is what its brake takes less what its wheel gives: r F = -(T + J d omega/dt) by (2.15), whatever
the road and however far the wheel slips. Drag, slope and engine are not in it.
"""

from collections.abc import Sequence
from math import isfinite, nan

import numpy as np

from vehicle_models.vehicle import Vehicle

_LONGEST_STEP = 0.1
"""Time between samples over which a pressure is taken to last [s]."""


class BrakedSpeed:
    """Integrates over the samples of a car."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the car."""
        momentum = np.array([1.0 / (wheel.radius * vehicle.mass) for wheel in vehicle.wheels])
        self._by_impulse = momentum * np.array([wheel.brake_gain for wheel in vehicle.wheels])
        self._by_spin = momentum * np.array([wheel.inertia for wheel in vehicle.wheels])
        self.reset()

    def reset(self) -> None:
        """Begin at 0."""
        self._last = 0.0
        self._braked = 0.0

    def update(self, time: float, wheel_speeds: Sequence[float], pressures: Sequence[float]) -> float:
        """Return the speed gained since the start [m/s], NaN where a wheel lacks its speed or its pressure.

        Args:
            time: stamp [s].
            wheel_speeds: speed of each wheel [rad/s].
            pressures: pressure of each brake [Pa].
        """
        step, self._last = time - self._last, time
        slowed = float(self._by_impulse @ np.asarray(pressures))
        if isfinite(slowed) and 0.0 < step <= _LONGEST_STEP:
            self._braked += step * slowed
        if not isfinite(slowed):
            return nan
        return -self._braked - float(self._by_spin @ np.asarray(wheel_speeds))
