"""Columns of iac_av21_putnam_25hz.csv as our input topics.

The wheel speeds of the file are rim speeds in km/h. They become angular speeds by a nominal radius of 0.3 m, which is
no measurement: a node that is given the same radius gets back the speeds of the file.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from friction_msgs.msg import BrakeDemand
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu, JointState

from friction_runtime.stamps import NANOSECONDS, from_nanoseconds

NOMINAL_RADIUS = 0.3
"""[m]"""
WHEELS = {
    "front_left": "wheel_fl(kmph)",
    "front_right": "wheel_fr(kmph)",
    "rear_left": "wheel_rl(kmph)",
    "rear_right": "wheel_rr(kmph)",
}
COLUMNS = (
    "time(s)",
    "vx(m/s)",
    "vy(m/s)",
    "omega(rad/s)",
    "ax(m/s^2)",
    *WHEELS.values(),
    "brake_ped_cmd(kPa)",
)
NOTES = {
    "source": "Indy AV-21 at Putnam, linklab-uva/deep-dynamics at 88c8565 (GPL-3.0), iac_av21_putnam_25hz.csv",
    "stamps": "time(s) of the file",
    "wheel_speed": f"rim speed in km/h of the file, by a nominal radius of {NOMINAL_RADIUS} m",
    "brakes": "no pressure at a wheel was recorded; brake_demand is the commanded line pressure",
}

_KMPH = 1.0 / 3.6
_KILOPASCAL = 1e3


def messages(rows: Iterable[Mapping[str, float]]) -> Iterator[tuple[str, Any]]:
    """Yield topic and message: wheel_states, imu/data, vehicle_velocity and brake_demand of each row."""
    for row in rows:
        stamp = from_nanoseconds(round(row["time(s)"] * NANOSECONDS))
        wheels = JointState(
            name=list(WHEELS), velocity=[row[column] * _KMPH / NOMINAL_RADIUS for column in WHEELS.values()]
        )
        imu = Imu()
        imu.header.frame_id = "base_link"
        imu.orientation_covariance[0] = -1.0
        imu.angular_velocity.z = row["omega(rad/s)"]
        imu.linear_acceleration.x = row["ax(m/s^2)"]
        speed = TwistWithCovarianceStamped()
        speed.header.frame_id = "base_link"
        speed.twist.twist.linear.x = row["vx(m/s)"]
        speed.twist.twist.linear.y = row["vy(m/s)"]
        demand = BrakeDemand(pressure=row["brake_ped_cmd(kPa)"] * _KILOPASCAL)
        demand.header.frame_id = "base_link"
        for topic, message in (
            ("/wheel_states", wheels),
            ("/imu/data", imu),
            ("/vehicle_velocity", speed),
            ("/brake_demand", demand),
        ):
            message.header.stamp = stamp
            yield topic, message
