"""Axes of an IMU across the car, with the errors of one drive and the noise of each sample."""

from typing import Final

import numpy as np

_BIAS: Final = 0.1, 0.01
"""Deviations of the errors of a drive: lateral acceleration [m/s^2] and yaw rate [rad/s]."""
_NOISE: Final = 0.05, 0.003
"""The same of a sample."""


class CrossAxes:
    """Lateral acceleration and yaw rate as they are read in one drive."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw the errors of the drive; the noise is drawn from the same generator."""
        self._rng = rng
        self._bias, self._turn_bias = rng.normal(0.0, _BIAS).tolist()

    def read(self, leftward: float, yaw_rate: float) -> tuple[float, float]:
        """Return a reading of a lateral acceleration to the left [m/s^2] and a yaw rate [rad/s]."""
        noise, turn_noise = self._rng.normal(0.0, _NOISE).tolist()
        return leftward + self._bias + noise, yaw_rate + self._turn_bias + turn_noise
