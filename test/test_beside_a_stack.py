"""The graph beside a vehicle stack, over DDS: a car with names of its own, and no publisher of brake commands."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
from friction_msgs.msg import SupervisorState, WheelSlip
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header

from dds_client import DdsClient, dds_client
from friction_bags.offline.estimators import ESTIMATORS
from friction_bringup import graph
from friction_bringup.node_start import WATCHING, node_starts
from friction_runtime import qos
from friction_runtime.stamps import from_nanoseconds

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
        return len(slips) == len(states) == 4 and all(slip.valid for slip in slips.values())

    client.until(answered)
    for slip in slips.values():
        assert slip.slip == pytest.approx(0.0, abs=0.02)
        assert slip.wheel_speed == pytest.approx(20.0 / 0.3, rel=0.01)
