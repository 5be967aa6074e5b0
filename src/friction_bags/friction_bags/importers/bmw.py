"""Columns of bmw_m8_abs_stop_100hz.csv as our input topics.

The stamps are t_s + 1000 s, exact to the nanosecond: t_s begins below zero, which a stamp cannot. The file is strictly
increasing, so nothing is reordered; bursts of samples less than 3 ms apart are kept.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from sensor_msgs.msg import JointState

from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers.car_messages import imu, velocity
from friction_runtime.stamps import from_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

STAMP_OFFSET = 1000
"""Offset added to t_s [s]."""
WHEELS = {
    "front_left": "w_fl_radps",
    "front_right": "w_fr_radps",
    "rear_left": "w_rl_radps",
    "rear_right": "w_rr_radps",
}
COLUMNS = (
    "t_s",
    "vx_mps",
    "vy_mps",
    "ax_mps2",
    "ay_mps2",
    "yaw_rate_radps",
    *WHEELS.values(),
    "brake_torque_can",
)
BRAKE_TORQUE_TOPIC = "/can/total_brake_torque_request"
NOTES = {
    "source": "BMW M8, roadview-project/vehicle-dynamics at 8fe8b60 (MIT), bmw_m8_abs_stop_100hz.csv",
    "stamps": f"t_s + {STAMP_OFFSET} s",
    "brakes": "no brake pressure was recorded, so there is none here; "
    f"{BRAKE_TORQUE_TOPIC[1:]} is the request for all four wheels together upstream of the ABS, negative in braking",
    "effective_radius": "not measured; own estimate from coasting, in the vehicle file",
    "parameters": "bmw_m8",
    VEHICLE_NOTE: "bmw_m8",
}


def messages(rows: Iterable[Mapping[str, float]]) -> Iterator[tuple[str, Any]]:
    """Yield topic and message: wheel_states, imu/data, vehicle_velocity and the brake torque request of each row."""
    for row in rows:
        stamp = from_nanoseconds(round(row["t_s"] * NANOSECONDS) + STAMP_OFFSET * NANOSECONDS)
        wheels = JointState(name=list(WHEELS), velocity=[row[column] for column in WHEELS.values()])
        torque = JointState(name=["all_wheels"], effort=[row["brake_torque_can"]])
        for topic, message in (
            ("/wheel_states", wheels),
            ("/imu/data", imu(row["yaw_rate_radps"], row["ax_mps2"], row["ay_mps2"])),
            ("/vehicle_velocity", velocity(row["vx_mps"], row["vy_mps"])),
            (BRAKE_TORQUE_TOPIC, torque),
        ):
            message.header.stamp = stamp
            yield topic, message
