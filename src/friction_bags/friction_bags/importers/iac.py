"""Columns of iac_av21_putnam_25hz.csv as our input topics.

The wheel speeds of the file are rim speeds in km/h. They are converted to angular speeds with the nominal radii of the
vehicle file, which are not measured: a node with the same car computes the speeds of the file again.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from friction_msgs.msg import BrakeDemand
from sensor_msgs.msg import JointState

from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers.car_messages import imu, velocity
from friction_runtime.stamps import from_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "indy_av21"
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
    "wheel_speed": "rim speed in km/h of the file, by the nominal radii of the vehicle file",
    "brakes": "no pressure at a wheel was recorded; brake_demand is the commanded line pressure",
    VEHICLE_NOTE: VEHICLE,
}

_KMPH = 1.0 / 3.6
_KILOPASCAL = 1e3


def messages(rows: Iterable[Mapping[str, float]]) -> Iterator[tuple[str, Any]]:
    """Yield topic and message: wheel_states, imu/data, vehicle_velocity and brake_demand of each row."""
    car = load_vehicle(VEHICLE)
    for row in rows:
        stamp = from_nanoseconds(round(row["time(s)"] * NANOSECONDS))
        wheels = JointState(
            name=list(WHEELS),
            velocity=[row[column] * _KMPH / car.wheel(name).radius for name, column in WHEELS.items()],
        )
        demand = BrakeDemand(pressure=row["brake_ped_cmd(kPa)"] * _KILOPASCAL)
        demand.header.frame_id = "base_link"
        for topic, message in (
            ("/wheel_states", wheels),
            ("/imu/data", imu(row["omega(rad/s)"], row["ax(m/s^2)"])),
            ("/vehicle_velocity", velocity(row["vx(m/s)"], row["vy(m/s)"])),
            ("/brake_demand", demand),
        ):
            message.header.stamp = stamp
            yield topic, message
