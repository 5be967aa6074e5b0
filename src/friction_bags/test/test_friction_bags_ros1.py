"""A bag of ROS 1 through a signal map."""

from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_runtime.installed import message_class

STATES = "sensor_msgs/msg/JointState"
MAP = f"""vehicle: compact_car
signals:
  wheel_speed: {{from: {{topic: /joints, type: {STATES}}}, field: "velocity[name={{wheel}}]", unit: rpm}}
"""
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def ros1_bag(path: Path) -> Path:
    store: Any = get_typestore(Stores.ROS1_NOETIC)
    types, none = store.types, np.array([], dtype=np.float64)
    with Writer(path) as bag:
        connection = bag.add_connection("/joints", STATES, typestore=store)
        for k in range(5):
            stamp = 10**9 + k * 10_000_000
            header = types["std_msgs/msg/Header"](k, types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), "")
            message = types[STATES](header, list(WHEELS), none, np.array([60.0, 120.0, 180.0, 240.0 + k]), none)
            bag.write(connection, stamp + 1000, store.serialize_ros1(message, STATES))
    return path


def imported(log: Path, directory: Path, text: str = MAP) -> int:
    (directory / "map.yaml").write_text(text)
    return main(["import", str(log), "--map", str(directory / "map.yaml"), "--out", str(directory / "out")])


def test_a_bag_of_ros_1_becomes_one_of_this_graph(tmp_path: Path) -> None:
    assert imported(ros1_bag(tmp_path / "drive.bag"), tmp_path) == 0
    with BagReader(tmp_path / "out") as reader:
        found = [(topic, stamp, decode(data, message_class(topic.type))) for topic, stamp, data in reader.messages()]
    assert len(found) == 5
    for k, (topic, stamp, message) in enumerate(found):
        assert (topic.name, stamp) == ("/wheel_states", 10**9 + k * 10_000_000)
        assert isclose(message.velocity[0], 6.283185307179586)
        assert isclose(message.velocity[3], (240.0 + k) / 60.0 * 6.283185307179586)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("/joints", "/wheels", "has no topic /wheels"),
        ("velocity[", "speed[", "no field 'speed': header, name, position, velocity, effort"),
        (STATES, "sensor_msgs/msg/Imu", "/joints is sensor_msgs/msg/JointState, and sensor_msgs/msg/Imu"),
    ],
)
def test_a_map_that_does_not_fit_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    assert imported(ros1_bag(tmp_path / "drive.bag"), tmp_path, MAP.replace(old, new)) == 2
    assert said in capsys.readouterr().err


def test_a_file_that_is_no_bag_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "drive.bag").write_bytes(b"no bag at all" * 100)
    assert imported(tmp_path / "drive.bag", tmp_path) == 2
    assert "drive.bag cannot be read" in capsys.readouterr().err
