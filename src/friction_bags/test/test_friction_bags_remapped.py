"""A bag of a car with other topics and units, through a signal map: the estimates are those of native topics."""

from collections.abc import Iterator
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import String

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic
from friction_bags.remapped_bag import EmbeddedType
from friction_runtime.installed import message_class

CAR = Path(__file__).parents[2] / "friction_adapter" / "test" / "four_wheels.yaml"
RADII = {"FL": 0.3, "FR": 0.3, "RL": 0.32, "RR": 0.32}
WHEELS = tuple(RADII)
REPORT = "acme_msgs/msg/WheelReport"
DEFINITION = f"""std_msgs/Header header
float64 front_left
float64 front_right
float64[2] rear
uint8[] none
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
VALUES = {
    "slip": ("slip", "slip_rate", "vehicle_speed", "slip_stddev"),
    "friction_slope": ("sign", "h", "indicator"),
}
MAP = f"""vehicle: {CAR}
signals:
  wheel_speed:
    from: {{topic: /acme/wheels, type: {REPORT}}}
    fields: {{FL: front_left, FR: front_right, RL: "rear[0]", RR: "rear[1]"}}
    unit: km/h
  acceleration: {{from: {{topic: /acme/imu, type: sensor_msgs/msg/Imu}}, field: linear_acceleration.y, sign: -1}}
  brake_pressure:
    from: {{topic: /acme/line, type: sensor_msgs/msg/FluidPressure}}
    fields: {{all: fluid_pressure}}
    unit: bar
"""


def stop() -> Iterator[tuple[int, dict[str, float], float, float]]:
    """Stamps [ns], speeds of the wheels [rad/s], acceleration [m/s^2] and pressure [Pa] of a stop at 200 Hz."""
    for k in range(300):
        braking = min(max(k - 100, 0) / 100.0, 1.0)
        speed = 25.0 - 5.0 * braking * max(k - 100, 0) * 0.005
        slip = 0.03 * braking
        speeds = {wheel: speed * (1.0 - slip) / radius for wheel, radius in RADII.items()}
        yield 10**9 + k * 5_000_000, speeds, -5.0 * braking, 4e6 * braking


def stamped(message: Any, stamp: int) -> Any:
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    return message


def native_bag(bag: Path) -> Path:
    joints = [f"wheel_{wheel.lower()}_joint" for wheel in WHEELS]
    with BagWriter(bag, custom_data={"vehicle": str(CAR)}) as writer:
        names: dict[str, type] = {"/wheel_states": JointState, "/imu/data": Imu}
        names |= {f"/{wheel}/brake_pressure": FluidPressure for wheel in WHEELS}
        channels = {name: writer.add_topic(installed_topic(name, kind)) for name, kind in names.items()}
        for stamp, speeds, acceleration, pressure in stop():
            imu = Imu()
            imu.linear_acceleration.x = acceleration
            sent = {"/wheel_states": JointState(name=joints, velocity=list(speeds.values())), "/imu/data": imu}
            sent |= {f"/{wheel}/brake_pressure": FluidPressure(fluid_pressure=pressure) for wheel in WHEELS}
            for name, message in sent.items():
                writer.write(channels[name], stamp, encode(stamped(message, stamp)))
    return bag


def report_cdr(stamp: int, speeds: dict[str, float]) -> bytes:
    """A message of the type that is not installed, by the same rules of CDR as one that is."""
    kmh = [speeds[wheel] * RADII[wheel] * 3.6 for wheel in WHEELS]
    store: Any = EmbeddedType(Topic("/acme/wheels", REPORT, DEFINITION, "ros2msg"))._store
    types = store.types
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    header = types["std_msgs/msg/Header"](time, "")
    message = types[REPORT](header, kmh[0], kmh[1], np.array(kmh[2:]), np.array([], dtype=np.uint8))
    return bytes(store.serialize_cdr(message, REPORT))


def foreign_bag(bag: Path) -> Path:
    with BagWriter(bag) as writer:
        wheels = writer.add_topic(Topic("/acme/wheels", REPORT, DEFINITION, "ros2msg"))
        line = writer.add_topic(installed_topic("/acme/line", FluidPressure))
        imus = writer.add_topic(installed_topic("/acme/imu", Imu))
        other = writer.add_topic(installed_topic("/acme/other", String))
        for stamp, speeds, acceleration, pressure in stop():
            imu = Imu()
            imu.linear_acceleration.y = -acceleration
            writer.write(wheels, stamp, report_cdr(stamp, speeds))
            writer.write(imus, stamp, encode(stamped(imu, stamp)))
            writer.write(line, stamp, encode(stamped(FluidPressure(fluid_pressure=pressure / 1e5), stamp)))
            writer.write(other, stamp, encode(String(data="kept")))
    return bag


def alike(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=1e-9, abs_tol=1e-9) or (one != one and other != other)


def decoded(bag: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    with BagReader(bag) as reader:
        for topic, _, data in reader.messages():
            if topic.type != REPORT:
                found.setdefault(topic.name, []).append(decode(data, message_class(topic.type)))
    return found


@pytest.fixture
def signal_map(tmp_path: Path) -> Path:
    path = tmp_path / "map.yaml"
    path.write_text(MAP)
    return path


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_estimates_through_a_map_are_those_of_native_topics(tmp_path: Path, signal_map: Path, jobs: str) -> None:
    common = ["--estimators", "wheel_slip", "friction_slope", "--jobs", jobs]
    assert main(["process", str(native_bag(tmp_path / "native")), "--out", str(tmp_path / "a"), *common]) == 0
    given = [str(foreign_bag(tmp_path / "foreign")), "--map", str(signal_map), "--out", str(tmp_path / "b")]
    assert main(["process", *given, *common]) == 0
    native, mapped = decoded(tmp_path / "a"), decoded(tmp_path / "b")
    assert {"/wheel_states", "/imu/data", "/RR/brake_pressure", "/acme/other"} <= mapped.keys()
    assert any(each.validity.valid for each in native["/RL/slip"])
    for topic in [f"/{wheel}/{kind}" for wheel in WHEELS for kind in ("slip", "friction_slope")]:
        assert len(native[topic]) == len(mapped[topic]) == 300
        for one, other in zip(native[topic], mapped[topic], strict=True):
            assert one.header.stamp == other.header.stamp
            assert (one.validity.valid, one.validity.reason) == (other.validity.valid, other.validity.reason)
        for name in VALUES[topic[4:]]:
            expected = np.array([getattr(each, name) for each in native[topic]])
            found = np.array([getattr(each, name) for each in mapped[topic]])
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.nanmax(abs(expected), initial=0.0))
    with BagReader(tmp_path / "b") as reader:
        assert reader.custom_data["vehicle"] == str(CAR)


def test_an_imported_bag_holds_what_the_map_makes_at_the_times_of_its_causes(tmp_path: Path, signal_map: Path) -> None:
    bag = foreign_bag(tmp_path / "foreign")
    assert main(["import", str(bag), "--map", str(signal_map), "--out", str(tmp_path / "out")]) == 0
    found = decoded(tmp_path / "out")
    assert set(found) == {"/wheel_states", "/imu/data", *(f"/{wheel}/brake_pressure" for wheel in WHEELS)}
    for (_, speeds, _, pressure), wheels, line in zip(
        stop(), found["/wheel_states"], found["/FL/brake_pressure"], strict=True
    ):
        assert all(alike(one, other) for one, other in zip(wheels.velocity, speeds.values(), strict=True))
        assert alike(line.fluid_pressure, pressure)
    with BagReader(tmp_path / "out") as reader, BagReader(bag) as source:
        assert (reader.start, reader.end) == (source.start, source.end)
        assert reader.custom_data["vehicle"] == str(CAR)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("front_right", "front_rigth", "no field 'front_rigth': header, front_left, front_right, rear, none"),
        ("/acme/line", "/acme/lines", "has no topic /acme/lines"),
        (REPORT, "acme_msgs/msg/Report", f"/acme/wheels is {REPORT}, and acme_msgs/msg/Report in"),
    ],
)
def test_a_map_that_does_not_fit_the_bag_is_refused_with_what_there_is(
    tmp_path: Path, signal_map: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    signal_map.write_text(MAP.replace(old, new))
    bag = foreign_bag(tmp_path / "foreign")
    assert main(["process", str(bag), "--map", str(signal_map), "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_message_as_rclpy_pads_it_is_read_by_its_definition() -> None:
    """It appends bytes to a message that ends with an empty sequence of doubles."""
    installed = installed_topic("/joints", JointState)
    definition = installed.definition
    foreign = EmbeddedType(Topic("/joints", "acme_msgs/msg/Joints", definition, "ros2msg"))
    message = foreign.decode(serialize_message(JointState(name=["a"], velocity=[1.5])))
    assert list(message.velocity) == [1.5]


def test_a_type_without_definition_is_refused() -> None:
    with pytest.raises(BagError, match="the bag holds no definition of it"):
        EmbeddedType(Topic("/x", "acme_msgs/msg/X"))
    with pytest.raises(BagError, match="cannot be read"):
        EmbeddedType(Topic("/x", "acme_msgs/msg/X", "no definition {", "ros2msg"))


def test_an_idl_definition_with_the_lines_of_its_recorder_is_read() -> None:
    text = """================================================================================
IDL: acme_msgs/msg/Speed
#include "builtin_interfaces/msg/Time.idl"

module acme_msgs { module msg { struct Speed { double value; }; }; };
"""
    assert set(EmbeddedType(Topic("/v", "acme_msgs/msg/Speed", text, "ros2idl")).fields.members) == {"value"}
