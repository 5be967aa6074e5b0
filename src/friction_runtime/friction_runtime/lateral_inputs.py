"""Motion across the car from an IMU: lateral acceleration and yaw rate, where it measures both."""

from math import isfinite, nan
from typing import Final

from sensor_msgs.msg import Imu

from vehicle_models.physical_bounds import HIGHEST_ACCELERATION
from vehicle_models.vehicle import Accelerometer

_HIGHEST_YAW_RATE: Final = 5.0
"""[rad/s] beyond which a reading is garbage: a car that turns on the spot on ice makes half of it."""
NOT_MEASURED: Final = (0.0, 0.0, 0.0)
MEASURED: Final = 1.0
"""Third number of a reading with values: so that one that is interpolated towards none counts as none."""


def yaw_rate_of(message: Imu) -> float:
    """Yaw rate [rad/s], NaN where it is garbage or not measured.

    REP 145 marks what is not measured with -1. A sensor without gyroscopes often leaves zeros all over instead.
    """
    rates = message.angular_velocity
    turned = bool(rates.x or rates.y or rates.z) and message.angular_velocity_covariance[0] >= 0.0
    return float(rates.z) if turned and abs(rates.z) <= _HIGHEST_YAW_RATE else nan


class LateralInput:
    """Reads imu/data."""

    def __init__(self, mounting: Accelerometer) -> None:
        """Take the mounting."""
        self._mounting = mounting
        self.reset()

    def reset(self) -> None:
        """Forget that an axis across the car was seen."""
        self._has_lateral = False

    def read(self, message: Imu) -> tuple[float, float, float]:
        """Return lateral acceleration to the left [m/s^2], yaw rate [rad/s] and MEASURED, or NOT_MEASURED."""
        mounting = self._mounting
        leftward, yaw_rate = mounting.sign * float(message.linear_acceleration.y), yaw_rate_of(message)
        # a sensor of one axis leaves the others at zero
        self._has_lateral = self._has_lateral or (mounting.axis == "x" and leftward != 0.0)
        if isfinite(yaw_rate) and self._has_lateral and abs(leftward) <= HIGHEST_ACCELERATION:
            return leftward, yaw_rate, MEASURED
        return NOT_MEASURED
