"""The graph beside a vehicle stack, over DDS: a car with names of its own, and no publisher of brake commands."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import pytest
from friction_msgs.msg import SupervisorState, WheelSlip
from rclpy.node import Node, NodeNameNonExistentError
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header

from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup import graph
from friction_bringup.node_start import WATCHING, node_starts
from friction_bringup.security_policies import policies
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client

PERIOD = 5_000_000
JOINTS = {"FL": "car::wheel_fl", "FR": "front-right", "RL": "car::wheel_rl", "RR": "rear-right"}
CAR = f"""
name: my car
mass: 1500
front_load_share: 0.5
wheelbase: 2.7
centre_of_gravity_height: 0.5
track: 1.5
all_wheels: {{radius: 0.3, inertia: 1.0, brake_gain: 1.0e-4}}
wheels:
  FL: {{axle: front, side: left, joint: "{JOINTS["FL"]}"}}
  FR: {{axle: front, side: right, joint: "{JOINTS["FR"]}"}}
  RL: {{axle: rear, side: left, joint: "{JOINTS["RL"]}"}}
  RR: {{axle: rear, side: right, joint: "{JOINTS["RR"]}"}}
"""
WANTS_COMMANDS = """
/**: {ros__parameters: {shadow: false}}
/**/abs_supervisor: {ros__parameters: {shadow: false}}
/my_car/abs_supervisor: {ros__parameters: {shadow: false}}
"""


def test_graph_beside_a_stack_estimates_every_wheel_by_its_joint_and_has_no_brake_command(tmp_path: Path) -> None:
    (tmp_path / "car.yaml").write_text(CAR)
    (tmp_path / "parameters.yaml").write_text(WANTS_COMMANDS)
    files = str(tmp_path / "parameters.yaml"), str(tmp_path / "car.yaml")
    with dds_client(["--ros-args", "-r", "__ns:=/my_car"]) as client:
        for start in node_starts(ESTIMATORS, WATCHING, *files, "my_car"):
            client.start(*graph.command(start.node, start.files, start.decided, "my_car")[1:])
        drive(client)
        node = client.node
        estimates = [f"{wheel}/{estimate}" for wheel in JOINTS for estimate in graph.ESTIMATES]
        client.until(lambda: all(node.count_publishers(topic) == 1 for topic in estimates))
        assert not [name for name, _ in node.get_topic_names_and_types() if graph.COMMAND in name]
        text = policies(str(tmp_path / "car.yaml"), [tmp_path / "parameters.yaml"], "my_car")
        for name in ESTIMATORS:
            client.until(partial(acts_as_allowed, node, name, text))


def acts_as_allowed(node: Node, name: str, text: str) -> bool:
    """Whether a node publishes, reads and answers exactly what its policy says, as far as is seen now."""
    (profile,) = ElementTree.fromstring(text).iterfind(f"enclaves/enclave[@path='/my_car/{name}']/profiles/profile")
    assert (profile.get("ns"), profile.get("node")) == ("/my_car", name)

    def allowed(path: str) -> set[str]:
        private = f"/my_car/{name}"
        names = [str(each.text) for each in profile.iterfind(path)]
        return {n.replace("~", private) if n[0] in "/~" else f"/my_car/{n}" for n in names}

    def seen(found: Callable[[str, str], list[tuple[str, list[str]]]]) -> set[str]:
        try:
            return {topic for topic, _ in found(name, "/my_car")}
        except NodeNameNonExistentError:  # not discovered yet
            return set()

    return (
        allowed("topics[@publish='ALLOW']/topic") == seen(node.get_publisher_names_and_types_by_node)
        and allowed("topics[@subscribe='ALLOW']/topic") == seen(node.get_subscriber_names_and_types_by_node)
        and allowed("services[@reply='ALLOW']/service") == seen(node.get_service_names_and_types_by_node)
    )


@pytest.mark.parametrize("commanding", [False, True])
def test_only_a_supervisor_that_commands_may_publish_brake_commands(commanding: bool) -> None:
    root = ElementTree.fromstring(policies("compact_car", commanding=commanding))
    publishers = {
        profile.get("node")
        for profile in root.iterfind("enclaves/enclave/profiles/profile")
        for topic in profile.iterfind("topics[@publish='ALLOW']/topic")
        if graph.COMMAND in str(topic.text)
    }
    assert publishers == ({graph.SUPERVISOR} if commanding else set())


def test_estimators_of_one_process_share_an_enclave_and_keep_their_profiles() -> None:
    root = ElementTree.fromstring(policies("compact_car", namespace="/car", composed=True))
    found = {
        str(enclave.get("path")): [profile.get("node") for profile in enclave.iterfind("profiles/profile")]
        for enclave in root.iterfind("enclaves/enclave")
    }
    assert set(found) == {"/car/estimators", "/car/abs_supervisor"}
    assert set(found["/car/estimators"]) == set(graph.COMPOSED)


def drive(client: DdsClient) -> None:
    """Drive at a steady 20 m/s until the slip of each wheel is known and each supervisor publishes."""
    node = client.node
    slips: dict[str, WheelSlip] = {}
    states: dict[str, SupervisorState] = {}
    for wheel in JOINTS:
        qos.subscribe(node, WheelSlip, f"{wheel}/slip", partial(slips.__setitem__, wheel), qos.SENSOR)
        qos.subscribe(node, SupervisorState, f"{wheel}/abs_supervisor", partial(states.__setitem__, wheel), qos.SENSOR)
    wheel_states, imu = qos.publish(node, JointState, "wheel_states"), qos.publish(node, Imu, "imu/data")
    stamp = 1_000_000_000

    def answered() -> bool:
        nonlocal stamp
        stamp += PERIOD
        header = Header(stamp=from_nanoseconds(stamp))
        imu.publish(Imu(header=header))
        names = ["steering", *reversed(JOINTS.values())]
        speeds = [0.1] + [20.0 / 0.3] * 4
        wheel_states.publish(JointState(header=header, name=names, velocity=speeds))
        return len(slips) == len(states) == 4 and all(slip.validity.valid for slip in slips.values())

    client.until(answered)
    for slip in slips.values():
        assert slip.slip == pytest.approx(0.0, abs=0.02)
        assert slip.wheel_speed == pytest.approx(20.0 / 0.3, rel=0.01)
