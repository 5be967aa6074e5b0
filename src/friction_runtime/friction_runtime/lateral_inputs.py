"""Motion across the car from an IMU: lateral acceleration and yaw rate, where it measures both."""

from typing import Final

from sensor_msgs.msg import Imu

from vehicle_models.physical_bounds import HIGHEST_ACCELERATION
from vehicle_models.vehicle import Accelerometer

_HIGHEST_YAW_RATE: Final = 10.0
"""[rad/s]"""
NOT_MEASURED: Final = (0.0, 0.0, 0.0)
MEASURED: Final = 1.0
"""Third number of a reading with values: so that one that is interpolated towards none counts as none."""


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
        leftward, yaw_rate = mounting.sign * float(message.linear_acceleration.y), float(message.angular_velocity.z)
        # a sensor of one axis leaves the others at zero
        self._has_lateral = self._has_lateral or (mounting.axis == "x" and leftward != 0.0)
        turns = abs(yaw_rate) <= _HIGHEST_YAW_RATE and message.angular_velocity_covariance[0] >= 0.0
        if turns and self._has_lateral and abs(leftward) <= HIGHEST_ACCELERATION:
            return leftward, yaw_rate, MEASURED
        return NOT_MEASURED
