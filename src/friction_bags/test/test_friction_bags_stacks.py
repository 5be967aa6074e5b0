"""Shipped maps on messages of their stacks' public definitions, as a bag holds them: none of the types is installed."""

from collections.abc import Callable, Mapping
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_adapter.map_file import load_map
from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic, message_definition
from friction_runtime.installed import message_class
from vehicle_models.vehicle_file import load_vehicle

FIELDS = {
    "raptor_dbw_msgs/msg/WheelSpeedReport": "std_msgs/Header header\n"
    "float32 front_left\nfloat32 front_right\nfloat32 rear_left\nfloat32 rear_right\n",
    "raptor_dbw_msgs/msg/Brake2Report": "std_msgs/Header header\n"
    "float32 brake_pressure\nfloat32 estimated_road_slope\nfloat32 speed_set_point\n",
    "autoware_vehicle_msgs/msg/VelocityReport": "std_msgs/Header header\n"
    "float32 longitudinal_velocity\nfloat32 lateral_velocity\nfloat32 heading_rate\n",
    "carla_msgs/msg/CarlaEgoVehicleStatus": "std_msgs/Header header\nfloat32 velocity\n"
    "geometry_msgs/Accel acceleration\ngeometry_msgs/Quaternion orientation\n"
    "float32 wheel_angle_fl\nfloat32 wheel_angle_fr\ncarla_msgs/CarlaEgoVehicleControl control\n",
    "carla_msgs/msg/CarlaEgoVehicleControl": "std_msgs/Header header\nfloat32 throttle\nfloat32 steer\nfloat32 brake\n"
    "bool hand_brake\nbool reverse\nint32 gear\nbool manual_gear_shift\n",
    "vesc_msgs/msg/VescImuStamped": "std_msgs/Header header\nvesc_msgs/VescImu imu\n",
    "vesc_msgs/msg/VescImu": "geometry_msgs/Vector3 ypr\ngeometry_msgs/Vector3 linear_acceleration\n"
    "geometry_msgs/Vector3 angular_velocity\ngeometry_msgs/Vector3 compass\ngeometry_msgs/Quaternion orientation\n",
}
"""Fields of public definitions, without their comments."""
REFERRED = (
    *("std_msgs/msg/Header", "builtin_interfaces/msg/Time"),
    *("geometry_msgs/msg/Accel", "geometry_msgs/msg/Vector3", "geometry_msgs/msg/Quaternion"),
)
STEPS = 300


def definition(name: str) -> str:
    """A definition as a bag embeds it."""
    package = name.split("/")[0]
    parts = [FIELDS[name]]
    for other in (*(each for each in FIELDS if each.startswith(package) and each != name), *REFERRED):
        text = FIELDS.get(other) or message_definition(other).text.split("=" * 80)[0]
        parts.append(f"{'=' * 80}\nMSG: {other.replace('/msg/', '/')}\n{text}")
    return "".join(parts)


class Writer:
    """Writes messages of any type, by their fields."""

    def __init__(self, bag: BagWriter) -> None:
        self._bag = bag
        self._channels: dict[str, tuple[int, Any]] = {}

    def write(self, topic: str, kind: str, stamp: int, **values: Any) -> None:
        """Write a message; a name with __ is that of a field of a field."""
        if topic not in self._channels:
            text = definition(kind)
            store: Any = get_typestore(Stores.EMPTY)
            store.register(get_types_from_msg(text, kind))
            self._channels[topic] = self._bag.add_topic(Topic(topic, kind, text, "ros2msg")), store
        channel, store = self._channels[topic]
        message = self._made(store, kind, values, stamp)
        self._bag.write(channel, stamp, bytes(store.serialize_cdr(message, kind)))

    def _made(self, store: Any, kind: str, values: Mapping[str, Any], stamp: int, prefix: str = "") -> Any:
        fields = []
        for name, (node, details) in store.get_msgdef(kind).fields:
            if details == "builtin_interfaces/msg/Time":
                fields.append(store.types[details](*divmod(stamp, 10**9)))
            elif int(node) == 2:
                fields.append(self._made(store, details, values, stamp, f"{prefix}{name}__"))
            else:
                fields.append(values.get(prefix + name, "" if details[0] == "string" else 0))
        return store.types[kind](*fields)


def stamped(message: Any, stamp: int) -> Any:
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    return message


def acceleration(value: float) -> Imu:
    message = Imu()
    message.linear_acceleration.x = value
    return message


def single(value: float) -> float:
    """A number as a float32 field holds it."""
    return float(np.float32(value))


def stop(k: int) -> tuple[float, float, float]:
    """Rim speed [m/s], acceleration [m/s^2] and pressure [bar] of sample k of a stop at 200 Hz."""
    braking = min(max(k - 100, 0) / 100.0, 1.0)
    speed = 25.0 - 5.0 * braking * max(k - 100, 0) * 0.005
    return speed * (1.0 - 0.03 * braking), -5.0 * braking, 40.0 * braking


Sample = tuple[list[float], float, list[float]]
"""Wheel speeds [rad/s], acceleration [m/s^2], pressures [Pa], as the native topics hold them."""


def raptor(writer: Writer, radii: list[float], stamp: int, k: int) -> Sample:
    rim, forward, bar = stop(k)
    speeds = [single(rim / radius) for radius in radii]
    names = ("front_left", "front_right", "rear_left", "rear_right")
    begin = "/raptor_dbw_interface/"
    report = dict(zip(names, speeds, strict=True))
    writer.write(f"{begin}wheel_speed_report", "raptor_dbw_msgs/msg/WheelSpeedReport", stamp, **report)
    writer.write(f"{begin}brake_2_report", "raptor_dbw_msgs/msg/Brake2Report", stamp, brake_pressure=single(bar))
    return speeds, forward, [single(bar) * 1e5] * 4


def av21(writer: Writer, radii: list[float], stamp: int, k: int) -> Sample:
    rim, forward, _ = stop(k)
    report = dict.fromkeys(("front_left", "front_right", "rear_left", "rear_right"), single(rim * 3.6))
    topic = "/raptor_dbw_interface/wheel_speed_report"
    writer.write(topic, "raptor_dbw_msgs/msg/WheelSpeedReport", stamp, **report)
    return [single(rim * 3.6) / 3.6 / radius for radius in radii], forward, []


def gazebo(_writer: Writer, radii: list[float], _stamp: int, k: int) -> Sample:
    rim, forward, _ = stop(k)
    return [rim / radius for radius in radii], forward, []


def alike(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=1e-9, abs_tol=1e-9) or (one != one and other != other)


def decoded(bag: Path, end: str) -> list[Any]:
    with BagReader(bag) as reader:
        topics = [topic for topic in reader.counts if topic.name.endswith(end)]
        return [decode(data, message_class(topic.type)) for topic, _, data in reader.messages(topics)]


@pytest.mark.parametrize(
    ("name", "vehicle", "imu", "stack"),
    [
        ("raptor", "compact_car", "/raptor_dbw_interface/imu/data_raw", raptor),
        ("av21", "indy_av21", "/vectornav/imu", av21),
        ("gazebo", "compact_car", "/imu", gazebo),
    ],
)
def test_estimates_of_a_stack_are_those_of_native_topics(
    tmp_path: Path, name: str, vehicle: str, imu: str, stack: Callable[[Writer, list[float], int, int], Sample]
) -> None:
    car = load_vehicle(vehicle)
    with BagWriter(tmp_path / "foreign") as foreign, BagWriter(tmp_path / "native") as native:
        writer = Writer(foreign)
        imus = foreign.add_topic(installed_topic(imu, Imu)), native.add_topic(installed_topic("/imu/data", Imu))
        joint_states = foreign.add_topic(installed_topic("/joint_states", JointState))
        wheels = native.add_topic(installed_topic("/wheel_states", JointState))
        lines = [native.add_topic(installed_topic(f"/{w}/brake_pressure", FluidPressure)) for w in car.wheel_names]
        for k in range(STEPS):
            stamp = 10**9 + k * 5_000_000
            speeds, forward, pressures = stack(writer, list(car.radii), stamp, k)
            for bag, channel in zip((foreign, native), imus, strict=True):
                bag.write(channel, stamp, encode(stamped(acceleration(forward), stamp)))
            states = stamped(JointState(name=list(car.joints), velocity=speeds), stamp)
            native.write(wheels, stamp, encode(states))
            shuffled = JointState(name=["steering", *reversed(car.joints)], velocity=[0.1, *reversed(speeds)])
            foreign.write(joint_states, stamp, encode(stamped(shuffled, stamp)))
            for channel, pressure in zip(lines, pressures, strict=False):
                native.write(channel, stamp, encode(stamped(FluidPressure(fluid_pressure=pressure), stamp)))
    common = ["--vehicle", vehicle, "--estimators", "wheel_slip", "friction_slope", "--outputs-only", "--jobs", "1"]
    assert main(["process", str(tmp_path / "native"), *common, "--out", str(tmp_path / "a")]) == 0
    given = [str(tmp_path / "foreign"), "--map", name, *common, "--out", str(tmp_path / "b")]
    assert main(["process", *given]) == 0
    for end, values in (("/slip", ("slip", "slip_rate", "vehicle_speed")), ("/friction_slope", ("h", "indicator"))):
        one, other = decoded(tmp_path / "a", end), decoded(tmp_path / "b", end)
        assert len(one) == len(other) > 3 * STEPS
        for expected, found in zip(one, other, strict=True):
            assert (expected.wheel, expected.validity.valid, expected.validity.reason) == (
                found.wheel,
                found.validity.valid,
                found.validity.reason,
            )
            assert all(alike(getattr(expected, value), getattr(found, value)) for value in values)
        assert any(each.validity.valid for each in one) or end != "/slip"


@pytest.mark.parametrize("name", ["autoware", "carla", "f1tenth"])
def test_a_stack_without_wheel_speeds_is_told_what_cannot_be_estimated_and_what_to_add(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    with BagWriter(tmp_path / "foreign") as foreign:
        writer = Writer(foreign)
        if name == "autoware":
            topic, kind = "/vehicle/status/velocity_status", "autoware_vehicle_msgs/msg/VelocityReport"
            writer.write(topic, kind, 10**9, longitudinal_velocity=12.5, lateral_velocity=0.5)
        elif name == "carla":
            writer.write(
                "/carla/ego_vehicle/vehicle_status", "carla_msgs/msg/CarlaEgoVehicleStatus", 10**9, velocity=12.5
            )
        else:
            vesc = {"imu__linear_acceleration__x": -0.5}
            writer.write("/sensors/imu", "vesc_msgs/msg/VescImuStamped", 10**9, **vesc)
        for topic in load_map(name, "compact_car").topics:
            if topic.startswith(("/carla/ego_vehicle/imu", "/sensing")):
                channel = foreign.add_topic(installed_topic(topic, Imu))
                foreign.write(channel, 10**9, encode(stamped(acceleration(-0.5 * 9.80665), 10**9)))
    given = [str(tmp_path / "foreign"), "--map", name, "--vehicle", "compact_car"]
    assert main(["import", *given, "--out", str(tmp_path / "bag")]) == 0
    said = capsys.readouterr().err
    assert "nothing can be estimated without 'wheel_speed': add the speed of each wheel" in said
    assert "without 'brake_pressure' there is no brake torque" in said
    assert decoded(tmp_path / "bag", "/imu/data")[0].linear_acceleration.x == pytest.approx(-0.5 * 9.80665)
    speeds = [each.twist.twist.linear.x for each in decoded(tmp_path / "bag", "/vehicle_velocity")]
    assert speeds == ([] if name == "f1tenth" else [12.5])
    assert main(["process", *given, "--out", str(tmp_path / "out")]) == 2
    assert "holds no /wheel_states" in capsys.readouterr().err
