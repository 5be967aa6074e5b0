"""Quantities of a signal map, each with its dimension and the message that carries it."""

from dataclasses import dataclass
from typing import Final

WHEEL_STATES: Final = "wheel_states"
IMU: Final = "imu/data"
VEHICLE_VELOCITY: Final = "vehicle_velocity"
BRAKE_PRESSURE: Final = "brake_pressure"
BRAKE_DEMAND: Final = "brake_demand"
BRAKE_TORQUE_REQUEST: Final = "can/total_brake_torque_request"


@dataclass(frozen=True)
class Quantity:
    """One quantity."""

    name: str
    dimension: str
    """Key of the table of units."""
    message: str
    """Topic of the message that carries it, below the wheel for `brake_pressure`."""
    per_wheel: bool
    needs: str
    """Quantity that the message has no meaning without; empty for none but itself."""
    has_stddev: bool
    """Whether the message carries its standard deviation."""
    description: str


QUANTITIES: Final = {
    each.name: each
    for each in (
        Quantity("wheel_speed", "wheel_speed", WHEEL_STATES, True, "", False, "speed of each wheel"),
        Quantity("acceleration", "acceleration", IMU, False, "", True, "reading of the accelerometer along the car"),
        Quantity("lateral_acceleration", "acceleration", IMU, False, "acceleration", False, "leftward positive"),
        Quantity("yaw_rate", "yaw_rate", IMU, False, "acceleration", False, "counter-clockwise positive"),
        Quantity("speed", "speed", VEHICLE_VELOCITY, False, "", True, "speed of the car, forward positive"),
        Quantity("lateral_speed", "speed", VEHICLE_VELOCITY, False, "speed", False, "leftward positive"),
        Quantity("brake_pressure", "pressure", BRAKE_PRESSURE, True, "", True, "pressure at the brake of each wheel"),
        Quantity("brake_demand", "pressure", BRAKE_DEMAND, False, "", False, "line pressure that the driver demands"),
        Quantity(
            "brake_torque_request",
            "torque",
            BRAKE_TORQUE_REQUEST,
            False,
            "",
            False,
            "brake torque of all wheels together; kept in the bag, no estimator takes it",
        ),
    )
}
"""By name, in the order in which the messages of one instant are sent."""
