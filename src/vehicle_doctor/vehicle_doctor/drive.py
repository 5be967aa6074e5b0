"""A drive as arrays, topic by topic, as it was recorded."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import TwistWithCovarianceStamped
from numpy.typing import NDArray
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.messages import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

WHEEL_STATES, IMU, SPEED = "wheel_states", "imu/data", "vehicle_velocity"


@dataclass(frozen=True)
class Recorded:
    """The messages of one topic in the order in which they came."""

    stamp: Array
    """Stamps [s since the first message of the drive], shape (N,)."""
    arrival: Array
    """When they were recorded [s since the same], shape (N,)."""
    values: Array
    """Shape (N, k): the wheels [rad/s] in the order of the car, NaN where one is missing; a pressure [Pa]; of the IMU
    acceleration x, y, z [m/s^2], yaw rate [rad/s]; a speed [m/s]."""


@dataclass(frozen=True)
class Drive:
    """A drive of a car."""

    vehicle: Vehicle
    topics: Mapping[str, Recorded]
    """By relative topic; those without a message are not there."""
    others: Collection[str]
    """Relative topics that are there too, and are not looked into."""
    strange_joints: tuple[str, ...] = ()
    """Names in wheel_states that are no wheel of the car."""
    wheels_in_parts: tuple[tuple[str, ...], ...] = ()
    """Names of the wheels of each kind of message, where wheel_states of the car comes in parts; else none."""
    unstamped: int = 0
    """Messages whose stamp is zero or below; they are ignored."""


def pressure_topic(wheel: str) -> str:
    """Topic of the brake pressure of a wheel."""
    return f"{wheel}/brake_pressure"


def kinds(vehicle: Vehicle) -> dict[str, type]:
    """Topics that the doctor looks into, with their types."""
    pressures = dict.fromkeys(map(pressure_topic, vehicle.wheel_names), FluidPressure)
    return {WHEEL_STATES: JointState, IMU: Imu, SPEED: TwistWithCovarianceStamped, **pressures}


def collect(vehicle: Vehicle, messages: Iterable[tuple[str, int, Any]], others: Collection[str]) -> Drive:
    """Make a drive of messages.

    Args:
        vehicle: the car.
        messages: relative topic of `kinds`, time of arrival [ns], message.
        others: relative topics besides these; it is read after the messages.
    """
    rows: dict[str, list[tuple[int, int, list[float]]]] = {}
    strange: dict[str, None] = {}
    parts: dict[tuple[str, ...], None] = {}
    unstamped = 0
    for topic, arrival, message in messages:
        stamp = to_nanoseconds(message.header.stamp)
        if stamp <= 0:
            unstamped += 1
            continue
        if topic == WHEEL_STATES:
            strange.update(dict.fromkeys(name for name in message.name if name not in vehicle.joints))
            parts[tuple(name for name in message.name if name in vehicle.joints)] = None
        rows.setdefault(topic, []).append((stamp, arrival, _values(topic, message, vehicle)))
    start = min((row[0][0] for row in rows.values()), default=0)
    found = {topic: _recorded(of_topic, start) for topic, of_topic in rows.items()}
    parts.pop((), None)
    is_in_parts = len(parts) > 1 and all(len(names) < len(vehicle.joints) for names in parts)
    return Drive(vehicle, found, frozenset(others), tuple(strange), tuple(parts) if is_in_parts else (), unstamped)


def _values(topic: str, message: Any, vehicle: Vehicle) -> list[float]:
    if topic == WHEEL_STATES:
        speeds = dict(zip(message.name, message.velocity, strict=False))
        return [speeds.get(joint, np.nan) for joint in vehicle.joints]
    if topic == IMU:
        force = message.linear_acceleration
        turning = message.angular_velocity.z if message.angular_velocity_covariance[0] >= 0.0 else np.nan
        return [force.x, force.y, force.z, turning]
    if topic == SPEED:
        return [message.twist.twist.linear.x]
    return [message.fluid_pressure]


def _recorded(rows: list[tuple[int, int, list[float]]], start: int) -> Recorded:
    stamps, arrivals, values = zip(*rows, strict=True)
    since = [np.array([each - start for each in times], dtype=np.float64) / NANOSECONDS for times in (stamps, arrivals)]
    return Recorded(since[0], since[1], np.array(values, dtype=np.float64))
