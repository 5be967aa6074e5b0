"""CAN logs of every format through one map and a DBC file: the same bag from each."""

from collections.abc import Iterator
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, message_definition
from friction_runtime.installed import message_class

can = pytest.importorskip("can", reason="python-can is absent: python3 -m pip install python-can cantools")
cantools = pytest.importorskip("cantools")

CAR = Path(__file__).parents[2] / "friction_adapter" / "test" / "four_wheels.yaml"
DBC = """VERSION ""
BU_: ESP
BO_ 416 Front: 8 ESP
 SG_ V_FL : 0|16@1+ (0.01,0) [0|655.35] "km/h" ESP
 SG_ V_FR : 16|16@1+ (0.01,0) [0|655.35] "km/h" ESP
 SG_ Ok_FL : 32|1@1+ (1,0) [0|1] "" ESP
 SG_ Ok_FR : 33|1@1+ (1,0) [0|1] "" ESP
BO_ 417 Rear: 8 ESP
 SG_ V_RL : 0|16@1+ (0.01,0) [0|655.35] "km/h" ESP
 SG_ V_RR : 16|16@1+ (0.01,0) [0|655.35] "km/h" ESP
 SG_ Ok_RL : 32|1@1+ (1,0) [0|1] "" ESP
 SG_ Ok_RR : 33|1@1+ (1,0) [0|1] "" ESP
BO_ 2566857472 Body: 8 ESP
 SG_ Ax : 0|16@1- (0.0005,0) [-16|16] "g" ESP
 SG_ P : 16|12@1+ (0.1,0) [0|400] "bar" ESP
BO_ 1000 Other: 8 ESP
 SG_ Rpm : 0|16@1+ (1,0) [0|65535] "rpm" ESP
"""
SIGNALS = """signals:
  wheel_speed: {from: {can: "V_{wheel}"}, valid: {field: "Ok_{wheel}", is: 1}}
  acceleration: {from: {can: Ax}}
  brake_pressure: {from: can, fields: {front: P}, latency: 0.012}
"""
FRAME = "can_msgs/msg/Frame"
FRAME_DEFINITION = """std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
"""
FORMATS = (".blf", ".asc", ".log", ".trc", ".csv")
STEPS = 50


@pytest.fixture
def signal_map(tmp_path: Path) -> Path:
    (tmp_path / "car.dbc").write_text(DBC)
    path = tmp_path / "map.yaml"
    path.write_text(f"vehicle: {CAR}\ncan: {{dbc: car.dbc, topic: /can}}\n{SIGNALS}")
    return path


def frames(start: float) -> Iterator[tuple[float, int, bool, bytes]]:
    """Time [s], identifier, whether it is extended, data: each instant in four frames within 1.5 ms."""
    bus: Any = cantools.database.load_string(DBC, "dbc")
    for k in range(STEPS):
        speed = 72.0 - k
        front = {"V_FL": speed, "V_FR": speed, "Ok_FL": 1, "Ok_FR": int(k != 7)}
        rear = {"V_RL": speed, "V_RR": speed + 1.0, "Ok_RL": 1, "Ok_RR": 1}
        sent = {"Rear": rear, "Front": front, "Body": {"Ax": -0.5, "P": 80.0}, "Other": {"Rpm": 900}}
        for place, (name, values) in enumerate(sent.items()):
            if (name, k) == ("Front", 20):
                continue  # lost
            message = bus.get_message_by_name(name)
            at = start + 0.01 * k + 0.0005 * place
            yield at, message.frame_id, message.is_extended_frame, message.encode(values)


def logged(path: Path, start: float) -> Path:
    with can.Logger(path) as log:
        for at, frame_id, is_extended, data in frames(start):
            log.on_message_received(
                can.Message(timestamp=at, arbitration_id=frame_id, is_extended_id=is_extended, data=data, channel=0)
            )
    return path


def imported(log: Path, signal_map: Path, bag: Path, *more: str) -> dict[str, list[tuple[int, Any]]]:
    """Recording stamp and message by topic."""
    assert main(["import", str(log), "--map", str(signal_map), *more, "--out", str(bag)]) == 1  # one frame is lost
    found: dict[str, list[tuple[int, Any]]] = {}
    with BagReader(bag) as reader:
        for topic, stamp, data in reader.messages():
            found.setdefault(topic.name, []).append((stamp, decode(data, message_class(topic.type))))
    return found


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_log_of_each_format_becomes_its_signals(tmp_path: Path, signal_map: Path, suffix: str) -> None:
    bag = imported(logged(tmp_path / f"drive{suffix}", 1.7e9), signal_map, tmp_path / "bag")
    assert set(bag) == {"/wheel_states", "/imu/data", "/FL/brake_pressure", "/FR/brake_pressure"}
    assert [len(messages) for messages in bag.values()] == [STEPS] * 4
    for k, (_, wheels) in enumerate(bag["/wheel_states"]):
        front, rear = (72.0 - k) / 3.6 / 0.3, (72.0 - k) / 3.6 / 0.32
        expected = [front, front, rear, rear + 1.0 / 3.6 / 0.32]
        there = [k != 20, k not in (7, 20), True, True]
        for speed, value, is_there in zip(wheels.velocity, expected, there, strict=True):
            assert isclose(speed, value, rel_tol=1e-9) if is_there else speed != speed
    for (_, imu), (_, pressure) in zip(bag["/imu/data"], bag["/FR/brake_pressure"], strict=True):
        assert isclose(imu.linear_acceleration.x, -0.5 * 9.80665)
        assert isclose(pressure.fluid_pressure, 8e6)
        late = imu.header.stamp.sec - pressure.header.stamp.sec
        assert late * 10**9 + imu.header.stamp.nanosec - pressure.header.stamp.nanosec == 12_000_000


@pytest.mark.parametrize("suffix", [".asc", ".blf", ".log", ".csv"])
def test_a_log_that_begins_at_zero_begins_at_1000_s(tmp_path: Path, signal_map: Path, suffix: str) -> None:
    bag = imported(logged(tmp_path / f"drive{suffix}", 0.0), signal_map, tmp_path / "bag")
    stamps = [stamp for stamp, _ in bag["/wheel_states"]]
    assert 1000 * 10**9 <= stamps[0] < 1000 * 10**9 + 10_000_000
    assert isclose((stamps[-1] - stamps[0]) * 1e-9, 0.01 * (STEPS - 1), abs_tol=1e-3)


def test_frames_on_a_topic_give_the_signals_of_a_log(tmp_path: Path, signal_map: Path) -> None:
    header = "=" * 80 + "\nMSG: std_msgs/Header\n" + message_definition("std_msgs/msg/Header").text
    topic = Topic("/can", FRAME, FRAME_DEFINITION + header, "ros2msg")
    store: Any = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(topic.definition, FRAME))
    types = store.types
    start = 1.7e9
    with BagWriter(tmp_path / "frames") as writer:
        channel = writer.add_topic(topic)
        for at, frame_id, is_extended, data in frames(start):
            stamp = round(at * 1e9)
            time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
            of_frame = types["std_msgs/msg/Header"](time, ""), frame_id, False, is_extended, False, 8
            message = types[FRAME](*of_frame, np.frombuffer(data, np.uint8))
            writer.write(channel, stamp, bytes(store.serialize_cdr(message, FRAME)))
    of_topic = imported(tmp_path / "frames", signal_map, tmp_path / "a")
    of_log = imported(logged(tmp_path / "drive.log", start), signal_map, tmp_path / "b")
    assert of_topic.keys() == of_log.keys()
    for name in of_log:
        for (_, one), (_, other) in zip(of_topic[name], of_log[name], strict=True):
            assert abs(one.header.stamp.nanosec - other.header.stamp.nanosec) <= 1000  # candump has microseconds
            one.header.stamp = other.header.stamp
            assert repr(one) == repr(other)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("{can: Ax}", "{can: LongAcc}", "has no CAN signal 'LongAcc': there are"),
        ("{can: Ax}", "{can: Ax}, unit: m/s^2", "its unit is m/s^2 here, and g where it comes from"),
        ("{front: P}", "{front: Other.Rpm}", "it comes in 'rpm': give its unit, one of Pa"),
        ("can: {dbc: car.dbc, topic: /can}", "", "needs a DBC file: 'can: {dbc: FILE}', or --dbc"),
    ],
)
def test_a_map_that_contradicts_the_dbc_file_is_refused(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    signal_map.write_text(signal_map.read_text().replace(old, new))
    log = logged(tmp_path / "drive.asc", 0.0)
    assert main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / "bag")]) == 2
    assert said in capsys.readouterr().err


def test_a_dbc_file_on_the_command_line_goes_before_that_of_the_map(tmp_path: Path, signal_map: Path) -> None:
    (tmp_path / "mph.dbc").write_text(DBC.replace("km/h", "mph"))
    log = logged(tmp_path / "drive.blf", 1.7e9)
    bag = imported(log, signal_map, tmp_path / "bag", "--dbc", str(tmp_path / "mph.dbc"))
    assert isclose(bag["/wheel_states"][0][1].velocity[0], 72.0 * 0.44704 / 0.3)


def test_a_log_that_is_none_is_refused(tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "drive.blf"
    for data in (b"", b"no log at all, but longer than a header" * 10):
        log.write_bytes(data)
        assert main(["import", str(log), "--map", str(signal_map), "--out", str(tmp_path / f"bag{len(data)}")]) == 2
        assert "drive.blf cannot be read" in capsys.readouterr().err
