"""Messages of a car's body from a row of measured data, without their stamp."""

from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu

_FRAME = "base_link"


def imu(yaw_rate: float, forward: float, leftward: float = 0.0) -> Imu:
    """Make imu/data from the yaw rate [rad/s] and the accelerations [m/s^2]; the orientation is not measured."""
    message = Imu()
    message.header.frame_id = _FRAME
    message.orientation_covariance[0] = -1.0
    message.angular_velocity.z = yaw_rate
    message.linear_acceleration.x = forward
    message.linear_acceleration.y = leftward
    return message


def velocity(forward: float, leftward: float) -> TwistWithCovarianceStamped:
    """Make vehicle_velocity from the speeds [m/s]."""
    message = TwistWithCovarianceStamped()
    message.header.frame_id = _FRAME
    message.twist.twist.linear.x = forward
    message.twist.twist.linear.y = leftward
    return message
