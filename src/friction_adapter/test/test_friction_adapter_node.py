"""The node as a real process over DDS: its messages are those of the processor; mistakes end it with one line."""

from functools import partial
from pathlib import Path

import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState

from friction_adapter.map_file import load_map
from friction_adapter.ros.processor import AdapterProcessor, installed_fields
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import silent
from friction_test_support.dds_client import dds_client, output_of, stop

CAR = Path(__file__).parent / "four_wheels.yaml"
STATES = "sensor_msgs/msg/JointState"
MAP = f"""vehicle: {CAR}
signals:
  wheel_speed: {{from: {{topic: joints, type: {STATES}}}, field: "velocity[name={{wheel}}]", unit: rpm}}
  acceleration: {{from: {{topic: /car/imu, type: sensor_msgs/msg/Imu}}, field: linear_acceleration.y, unit: g}}
"""


def joints(k: int) -> JointState:
    message = JointState(name=["RR", "RL", "FR", "FL"], velocity=[600.0 - k, 601.0, 602.0, 603.0])
    message.header.stamp = from_nanoseconds(k * 5_000_000)
    return message


def imu(k: int) -> Imu:
    message = Imu()
    message.header.stamp = from_nanoseconds(k * 5_000_000)
    message.linear_acceleration.y = -0.01 * k
    return message


@pytest.mark.parametrize("reliable", [True, False])
def test_node_makes_what_the_processor_makes_of_publishers_of_any_reliability(tmp_path: Path, reliable: bool) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(MAP)
    processor = AdapterProcessor(load_map(path), installed_fields, silent, arrival=lambda: 0)
    expected = [made for k in range(1, 41) for _, made in processor.process("joints", joints(k))]
    received: list[JointState] = []
    accelerations: list[Imu] = []
    with dds_client() as client:
        given = ("-p", f"vehicle_file:={CAR}", "-p", f"map_file:={path}")
        process = client.start("-m", "friction_adapter", "--ros-args", *given)
        profile = qos.ESTIMATE if reliable else qos_profile_sensor_data
        sender = client.node.create_publisher(JointState, "joints", profile)
        imus = client.node.create_publisher(Imu, "/car/imu", profile)
        qos.subscribe(client.node, JointState, "wheel_states", received.append, qos.SENSOR)
        qos.subscribe(client.node, Imu, "imu/data", accelerations.append, qos.SENSOR)
        for publisher in (sender, imus):
            client.until(lambda publisher=publisher: publisher.get_subscription_count() == 1)  # type: ignore[misc]
        for topic in ("wheel_states", "imu/data"):
            client.until(lambda topic=topic: client.node.count_publishers(topic) == 1)  # type: ignore[misc]
        client.until_known_to("friction_adapter")
        for k in range(1, 41):
            sender.publish(joints(k))
            client.until(partial(lambda count: len(received) >= count, k))
        imus.publish(imu(40))
        client.until(lambda: bool(accelerations))
        output = stop(process)
    assert repr(received) == repr(expected)
    assert accelerations[0].linear_acceleration.x == pytest.approx(-0.4 * 9.80665)
    assert process.returncode == 0
    assert "without 'brake_pressure' there is no brake torque" in output
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rpm", "knots", "line 3: 'knots' is no unit of 'wheel_speed': known are rad/s"),
        (
            "velocity[name",
            "velocities[name",
            "there is no field 'velocities': header, name, position",
        ),
        ("sensor_msgs/msg/Imu", "acme_msgs/msg/Imu", "type acme_msgs/msg/Imu is not installed"),
        ("/car/imu", "imu/data", "the map reads /imu/data, which this node makes"),
    ],
)
def test_a_bad_map_ends_the_node_with_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(MAP.replace(old, new))
    with dds_client() as client:
        given = ("-p", f"vehicle_file:={CAR}", "-p", f"map_file:={path}")
        process = client.start("-m", "friction_adapter", "--ros-args", *given)
        output = output_of(process)
    assert process.returncode == 2
    assert said in output
    assert "Traceback" not in output
