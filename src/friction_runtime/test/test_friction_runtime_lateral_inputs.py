"""Motion across the car: what an IMU measures, and what it does not."""

from math import inf, nan

import pytest
from sensor_msgs.msg import Imu

from friction_runtime.lateral_inputs import MEASURED, NOT_MEASURED, LateralInput
from vehicle_models.vehicle import Accelerometer


def imu(leftward: float, yaw_rate: float, covariance: float = 0.0) -> Imu:
    message = Imu()
    message.linear_acceleration.y, message.angular_velocity.z = leftward, yaw_rate
    message.angular_velocity_covariance[0] = covariance
    return message


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_both_are_read_with_the_sign_of_the_mounting(sign: float) -> None:
    assert LateralInput(Accelerometer(sign=sign)).read(imu(3.0, 0.2)) == (sign * 3.0, 0.2, MEASURED)


@pytest.mark.parametrize("yaw_rate, covariance", [(0.2, -1.0), (nan, 0.0), (11.0, 0.0), (0.0, 0.0)])
def test_without_a_yaw_rate_nothing_is_measured(yaw_rate: float, covariance: float) -> None:
    assert LateralInput(Accelerometer()).read(imu(3.0, yaw_rate, covariance)) == NOT_MEASURED


@pytest.mark.parametrize("leftward", [nan, inf, 1e3])
def test_garbage_is_not_measured(leftward: float) -> None:
    assert LateralInput(Accelerometer()).read(imu(leftward, 0.2)) == NOT_MEASURED


def test_an_axis_that_reads_zero_is_there_once_it_has_read_more() -> None:
    lateral = LateralInput(Accelerometer())
    assert lateral.read(imu(0.0, 0.2)) == NOT_MEASURED
    assert lateral.read(imu(0.1, 0.2)) == (0.1, 0.2, MEASURED)
    assert lateral.read(imu(0.0, 0.2)) == (0.0, 0.2, MEASURED)
    lateral.reset()
    assert lateral.read(imu(0.0, 0.2)) == NOT_MEASURED


def test_another_axis_along_the_car_leaves_it_unknown_which_is_across() -> None:
    assert LateralInput(Accelerometer(axis="z")).read(imu(3.0, 0.2)) == NOT_MEASURED
