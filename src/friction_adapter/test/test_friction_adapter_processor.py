"""Messages of a car in, messages of this graph out."""

import math
from pathlib import Path
from random import Random
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistWithCovarianceStamped, Vector3Stamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_adapter.map_file import load_map
from friction_adapter.ros.processor import AdapterProcessor, installed_fields
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import message_class
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from vehicle_models.vehicle_file import load_vehicle

CAR = Path(__file__).parent / "four_wheels.yaml"
JOINTS = load_vehicle(CAR).joints
STATES = "{topic: /joints, type: sensor_msgs/msg/JointState}"
WHEELS = f"wheel_speed: {{from: {STATES}, field: 'velocity[name=j_{{wheel}}]', unit: rpm}}"


def processor(directory: Path, *signals: str, top: str = "", said: list[str] | None = None) -> AdapterProcessor:
    path = directory / "map.yaml"
    path.write_text("\n".join([f"vehicle: {CAR}", top, "signals:", *(f"  {each}" for each in signals)]))
    lines = [] if said is None else said
    return AdapterProcessor(
        load_map(path),
        installed_fields,
        lambda severity, text: lines.append(f"{severity}: {text}"),
        arrival=lambda: 77,
        kind_of=message_class,
    )


def stamped(kind: Any, stamp: int, **fields: Any) -> Any:
    message = kind(**fields)
    message.header.stamp = from_nanoseconds(stamp)
    return message


def test_joints_are_found_by_name_in_any_order(tmp_path: Path) -> None:
    of_map = processor(tmp_path, WHEELS)
    assert of_map.sensors == {"/joints": JointState}
    assert of_map.outputs == {"wheel_states": JointState}
    names = ["steer", "j_RR", "j_RL", "j_FR", "j_FL"]
    message = stamped(JointState, 5_000_000_007, name=names, velocity=[9.0, 240.0, 180.0, 120.0, 60.0])
    ((topic, states),) = of_map.process("/joints", message)
    assert topic == "wheel_states"
    assert to_nanoseconds(states.header.stamp) == 5_000_000_007
    assert tuple(states.name) == JOINTS
    assert list(states.velocity) == pytest.approx([6.283185307179586 * k for k in (1, 2, 3, 4)], rel=1e-14)


def test_a_joint_that_is_missing_is_no_number_and_reported_once_for_each_time(tmp_path: Path) -> None:
    said: list[str] = []
    of_map = processor(tmp_path, WHEELS, said=said)
    message = stamped(JointState, 1, name=["j_FL", "j_FR", "j_RL"], velocity=[60.0, 60.0, 60.0])
    ((_, states),) = of_map.process("/joints", message)
    assert states.velocity[3] != states.velocity[3]
    assert said == ["warning: signal map: no value for 'wheel_speed' of RR"]
    assert of_map.health().message == "no value for 'wheel_speed' of RR"
    of_map.reset()
    assert of_map.health().message == "ok"


def test_imu_and_speed_carry_what_the_map_states(tmp_path: Path) -> None:
    imu = "{topic: /imu, type: sensor_msgs/msg/Imu}"
    twist = "{topic: /v, type: geometry_msgs/msg/Vector3Stamped}"
    of_map = processor(
        tmp_path,
        f"acceleration: {{from: {imu}, field: linear_acceleration.x, sign: -1, stddev: 0.5}}",
        f"speed: {{from: {twist}, field: vector.x, stddev: 0.3, stamp: arrival}}",
    )
    given = Imu()
    given.linear_acceleration.x = 3.0
    ((_, made),) = of_map.process("/imu", given)
    assert isinstance(made, Imu)
    assert made.linear_acceleration.x == -3.0
    assert made.linear_acceleration_covariance[0] == 0.25
    assert made.angular_velocity_covariance[0] == made.orientation_covariance[0] == -1.0
    velocity = Vector3Stamped()
    velocity.vector.x = 20.0
    ((topic, made),) = of_map.process("/v", velocity)
    assert isinstance(made, TwistWithCovarianceStamped)
    assert topic == "vehicle_velocity"
    assert (made.twist.twist.linear.x, made.twist.covariance[0]) == (20.0, pytest.approx(0.09))
    assert to_nanoseconds(made.header.stamp) == 77


def test_messages_of_one_stamp_become_one_when_the_last_has_come(tmp_path: Path) -> None:
    origin = '{topic: "/{wheel}", type: sensor_msgs/msg/FluidPressure}'
    of_map = processor(tmp_path, f"wheel_speed: {{from: {origin}, field: fluid_pressure}}")
    for wheel in ("RR", "FL", "RL"):
        assert of_map.process(f"/{wheel}", stamped(FluidPressure, 9, fluid_pressure=2.0)) == []
    ((_, states),) = of_map.process("/FR", stamped(FluidPressure, 9, fluid_pressure=3.0))
    assert list(states.velocity) == [2.0, 3.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        (
            f"wheel_speed: {{from: {STATES}, field: 'speed[name={{wheel}}]'}}",
            "no field 'speed': header, name",
        ),
        ("speed: {from: {topic: /v, type: no_msgs/msg/V}, field: v}", "type no_msgs/msg/V is not installed"),
        ("speed: {from: {topic: /v, type: os/msg/Path}, field: v}", "type os/msg/Path is not installed"),
        (f"speed: {{from: {STATES}, field: 'velocity[0]', stamp: header.time}}", "no field 'time' in header: stamp"),
        ("speed: {from: {column: v}}", "'speed': it comes from a table, and this is none"),
        ("speed: {from: {can: V}}", "CAN signals need 'can: {topic: TOPIC, dbc: FILE}'"),
    ],
)
def test_what_a_map_cannot_have_is_refused(tmp_path: Path, signal: str, said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        processor(tmp_path, signal)
    assert said in str(refused.value)


def test_whatever_a_message_holds_nothing_is_raised_and_what_is_made_can_be_sent(tmp_path: Path) -> None:
    draw = Random(7)
    numbers = (0.0, -1e308, 5e-324, math.inf, -math.inf, math.nan, 65.5)
    imu = "{topic: /imu, type: sensor_msgs/msg/Imu}"
    of_map = processor(
        tmp_path,
        f"acceleration: {{from: {imu}, field: linear_acceleration.x, valid: {{field: header.frame_id, is: ok}}}}",
        f"yaw_rate: {{from: {imu}, field: angular_velocity.z}}",
        f"wheel_speed: {{from: {STATES}, field: 'velocity[name=j_{{wheel}}]', unit: edges, counter: 256}}",
    )
    made: list[tuple[str, Any]] = []
    for _ in range(2000):
        stamp = Time(
            sec=draw.choice((-(2**31), -1, 0, 1, 2, 2**31 - 1)), nanosec=draw.choice((0, 10**7, 2 * 10**7, 2**32 - 1))
        )
        if draw.random() < 0.5:
            message = Imu()
            message.header.frame_id = draw.choice(("ok", ""))
            message.linear_acceleration.x, message.angular_velocity.z = draw.choice(numbers), draw.choice(numbers)
            topic = "/imu"
        else:
            names = draw.sample(["j_FL", "j_FR", "j_RL", "j_RR", "j_RR", ""], draw.randint(0, 6))
            velocity = [draw.choice(numbers) for _ in range(draw.randint(0, 6))]
            message, topic = JointState(name=names, velocity=velocity), "/joints"
        message.header.stamp = stamp
        made += of_map.process(topic, message)
    assert {topic for topic, _ in made} == {"imu/data", "wheel_states"}
    assert all(serialize_message(message) for _, message in made)
    assert of_map.health().message != "ok"
