"""The command of the vehicle doctor: output, exit code, JSON, and the vehicle file it writes."""

import json
import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.publisher import Publisher
from sensor_msgs.msg import Imu, JointState

from friction_bags.bag_io.bag_writer import write_bag
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_test_support.dds_client import dds_client, stop
from vehicle_doctor.__main__ import main
from vehicle_doctor.learned_vehicle import with_values
from vehicle_models.vehicle import Deviation, SharedBy
from vehicle_models.vehicle_file import load_vehicle

DATA = Path(os.environ.get("FRICTION_DATA", Path(__file__).parents[4] / "shared" / "data"))
TRUE = np.array([0.301, 0.299, 0.304, 0.3035])
FOUR = ["front_left", "front_right", "rear_left", "rear_right"]
CAR = """\
name: my car   # it is mine
mass: {value: 1620.0, stddev: 60.0}
front_load_share: 0.58
wheelbase: 2.68
centre_of_gravity_height: 0.54
track: 1.55
all_wheels:
  inertia: 1.1
  radius: {value: 0.3, stddev: 0.005}    # from the data sheet
  brake_gain: 1.0e-4
wheels:
  front_left: {axle: front, side: left, }
  front_right: {axle: front, side: right, radius: 0.302}    # worn
  rear_left:
    # the new one
    axle: rear
    side: left
    radius:
      value: 0.305
      # a comment below
    driven: true
  rear_right: {axle: rear, side: right, radius: {stddev: 0.1, value: 0.3015}}
"""


def rolling(seconds: float, factor: float = 1.0, age: float = 0.0, size: float = 1.0) -> list[tuple[str, Any]]:
    """A car that speeds up and slows gently at 200 Hz.

    Its accelerometer reads `factor` times the acceleration, its speed sensor the speed some `age` ago [s], and its
    radii are `size` times the true ones.
    """
    messages: list[tuple[str, Any]] = []
    generator = np.random.default_rng(2)
    for k in range(round(seconds / 0.005)):
        time = 0.005 * k
        stamp, speed, rate = (k + 1) * 5_000_000, 15.0 - 3.0 * np.cos(0.4 * time), 1.2 * np.sin(0.4 * time)
        wheels = JointState(name=FOUR, velocity=(speed / (size * TRUE) + 0.07 * generator.normal(size=4)).tolist())
        wheels.header.stamp = from_nanoseconds(stamp)
        imu = Imu()
        imu.header.stamp = from_nanoseconds(stamp)
        imu.linear_acceleration.x = factor * rate + 0.05 * generator.normal()
        messages += [("/wheel_states", wheels), ("/imu/data", imu)]
        if k % 20 == 0:
            sensor = TwistWithCovarianceStamped()
            sensor.header.stamp = from_nanoseconds(stamp)
            sensor.twist.twist.linear.x = 15.0 - 3.0 * np.cos(0.4 * (time - age))
            messages.append(("/vehicle_velocity", sensor))
    return messages


@pytest.fixture
def car(tmp_path: Path) -> Path:
    path = tmp_path / "my_car.yaml"
    path.write_text(CAR)
    return path


def test_what_a_drive_tells_is_written_into_the_vehicle_file(tmp_path: Path, car: Path) -> None:
    write_bag(tmp_path / "bag", rolling(40.0), {})
    out = tmp_path / "learned.yaml"
    # the file states 1 % and less for wheels that are 1.5 % off
    assert main([str(tmp_path / "bag"), "--vehicle", str(car), "--write", str(out)]) in (0, 1)
    learned = load_vehicle(out)
    assert learned.radii == pytest.approx(tuple(TRUE), rel=3e-3)
    for wheel in learned.wheels:
        assert 1e-6 <= wheel.deviations["radius"].stddev < 1.5e-3
        assert wheel.deviations["radius"].shared_by is SharedBy.WHEEL
    assert car.read_text() == CAR


def test_a_unit_is_named_in_json_and_by_the_exit_code(tmp_path: Path, car: Path) -> None:
    write_bag(tmp_path / "bag", rolling(40.0, factor=-1.0 / 9.81), {})
    file = tmp_path / "findings.json"
    assert main([str(tmp_path / "bag"), "--vehicle", str(car), "--json", str(file)]) == 1
    findings = json.loads(file.read_text())["findings"]
    of_imu = {each["check"]: each for each in findings if each["subject"] == "imu/data"}
    assert of_imu["unit"]["verdict"] == "FAIL"
    assert of_imu["unit"]["sentence"].startswith("is in g")
    assert "backwards" in of_imu["sign"]["sentence"]


def test_a_speed_of_long_ago_is_named_and_no_radius_is_learned_from_it(tmp_path: Path, car: Path) -> None:
    write_bag(tmp_path / "bag", rolling(40.0, age=1.5), {})
    file = tmp_path / "findings.json"
    assert main([str(tmp_path / "bag"), "--vehicle", str(car), "--json", str(file)]) == 1
    findings = json.loads(file.read_text())["findings"]
    (skew,) = [each for each in findings if (each["check"], each["subject"]) == ("skew", "vehicle_velocity")]
    assert skew["verdict"] == "FAIL"
    assert "not used here" in skew["sentence"]
    assert skew["value"] == pytest.approx(1500.0, abs=100.0)
    radii = [each["sentence"] for each in findings if each["check"] == "radius"]
    assert len(radii) == 4
    assert all("by the other wheels" in sentence for sentence in radii)


def test_radii_by_which_two_units_are_the_same_numbers_are_no_wrong_unit(tmp_path: Path, car: Path) -> None:
    """The wheels of a car with 0.28 m turn as fast in km/h as in rad/s."""
    size = 0.28 / 0.302
    write_bag(tmp_path / "bag", rolling(40.0, size=0.87 * size), {})
    small = tmp_path / "small.yaml"
    small.write_text(
        CAR.replace("0.305", "0.28")
        .replace("0.3015", "0.28")
        .replace("0.302", "0.28")
        .replace("value: 0.3,", "value: 0.28,")
    )
    file = tmp_path / "findings.json"
    assert main([str(tmp_path / "bag"), "--vehicle", str(small), "--json", str(file)]) == 1
    findings = json.loads(file.read_text())["findings"]
    assert not [each for each in findings if "km/h" in each["sentence"]]
    radii = [each["value"] for each in findings if each["check"] == "radius"]
    assert radii == pytest.approx((0.87 * size * TRUE).tolist(), rel=0.01)


def heard_by_one(publisher: Publisher) -> bool:
    return publisher.get_subscription_count() == 1


def test_live_topics_are_examined_as_a_bag_of_them_is(tmp_path: Path, car: Path) -> None:
    file = tmp_path / "findings.json"
    with dds_client() as client:
        options = ("--live", "100", "--vehicle", str(car), "--json", str(file))
        process = client.start("-m", "vehicle_doctor", *options, "--ros-args", "-r", "__ns:=/my_car")
        kinds = {"wheel_states": JointState, "imu/data": Imu, "vehicle_velocity": TwistWithCovarianceStamped}
        names = {topic: f"/my_car/{topic}" for topic in kinds}
        publishers = {
            f"/{topic}": client.node.create_publisher(kind, names[topic], qos.ESTIMATE) for topic, kind in kinds.items()
        }
        for publisher in publishers.values():
            client.until(partial(heard_by_one, publisher))
        client.until_known_to("my_car/doctor")
        for topic, message in rolling(20.0, factor=-1.0 / 9.81):
            publishers[topic].publish(message)
            client.executor.spin_once(timeout_sec=0.0)
        output = stop(process)
    assert process.returncode == 1, output
    said = {(each["check"], each["subject"]): each for each in json.loads(file.read_text())["findings"]}
    assert said[("unit", "imu/data")]["sentence"].startswith("is in g")
    assert said[("estimator", "wheel_slip")]["verdict"] == "OK"


@pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is absent (set FRICTION_DATA)")
@pytest.mark.parametrize(
    ("name", "file", "alarms"),
    [
        ("bmw", "bmw_m8_abs_stop_100hz.csv", set()),
        # its speed is 29 ms ahead of its wheels, its accelerometer more than a second late
        ("iac", "iac_av21_putnam_25hz.csv", {("skew", "vehicle_velocity"), ("skew", "imu/data")}),
    ],
)
def test_the_measured_drives_are_sound_but_for_what_is_named(
    tmp_path: Path, name: str, file: str, alarms: set[tuple[str, str]]
) -> None:
    findings = tmp_path / "findings.json"
    assert main([str(DATA / file), "--map", name, "--json", str(findings)]) == int(bool(alarms))
    said = json.loads(findings.read_text())["findings"]
    assert {(each["check"], each["subject"]) for each in said if each["verdict"] in ("WARN", "FAIL")} == alarms
    radii = {each["subject"]: each["value"] for each in said if each["check"] == "radius" and each["value"]}
    for axle in ("front", "rear") if radii else ():
        assert radii[f"{axle}_left"] == pytest.approx(radii[f"{axle}_right"], rel=3e-3)


@pytest.mark.parametrize("given", [(), ("bag", "--live", "3"), ("--live", "0"), ("--live", "3", "--map", "bmw")])
def test_a_drive_and_live_topics_are_one_or_the_other(car: Path, given: tuple[str, ...]) -> None:
    assert main([*given, "--vehicle", str(car)]) == 2


def test_a_bag_with_brakings_ends_with_their_table(capsys: pytest.CaptureFixture[str]) -> None:
    main([str(Path(__file__).parents[3] / "bags" / "abs_stop")])
    assert "Brakings of abs_stop" in capsys.readouterr().out


def test_a_car_that_stands_is_no_problem_and_no_crash(tmp_path: Path, car: Path) -> None:
    stamps = [(k + 1) * 5_000_000 for k in range(1000)]
    states = [JointState(name=FOUR, velocity=[0.0] * 4) for _ in stamps]
    for state, stamp in zip(states, stamps, strict=True):
        state.header.stamp = from_nanoseconds(stamp)
    write_bag(tmp_path / "bag", [("/wheel_states", state) for state in states], {})
    file = tmp_path / "findings.json"
    main([str(tmp_path / "bag"), "--vehicle", str(car), "--json", str(file)])
    said = {each["subject"]: each for each in json.loads(file.read_text())["findings"]}
    assert said["car"]["verdict"] == "NOTE"
    assert "does not move" in said["car"]["sentence"]
    assert "imu/data" in said["wheel_slip"]["sentence"]


def examined(bag: Path, car: Path, tmp_path: Path) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and findings."""
    file = tmp_path / "findings.json"
    code = main([str(bag), "--vehicle", str(car), "--json", str(file)])
    return code, json.loads(file.read_text())["findings"]


@pytest.mark.parametrize("ahead", [18.0, 1.7e9])
def test_wheels_on_another_clock_fail_and_no_estimator_has_its_inputs(tmp_path: Path, car: Path, ahead: float) -> None:
    messages = rolling(40.0)
    for topic, message in messages:
        if topic != "/wheel_states":
            stamp = message.header.stamp
            message.header.stamp = from_nanoseconds(stamp.sec * 10**9 + stamp.nanosec + round(ahead * 1e9))
    write_bag(tmp_path / "bag", messages, {})
    code, findings = examined(tmp_path / "bag", car, tmp_path)
    clocks = [each for each in findings if each["check"] == "clock"]
    assert code == 1
    assert {each["subject"] for each in clocks} == {"imu/data", "vehicle_velocity"}
    assert all(each["verdict"] == "FAIL" and "two clocks" in each["sentence"] for each in clocks)
    (slip,) = [each for each in findings if each["subject"] == "wheel_slip"]
    assert "lacks imu/data" in slip["sentence"]


def test_wheels_of_another_car_fail(tmp_path: Path, car: Path) -> None:
    messages = rolling(10.0)
    for topic, message in messages:
        if topic == "/wheel_states":
            message.name = [f"truck/{name}" for name in message.name]
    write_bag(tmp_path / "bag", messages, {})
    code, findings = examined(tmp_path / "bag", car, tmp_path)
    (wheels,) = [each for each in findings if each["subject"] == "wheel_states" and each["verdict"] == "FAIL"]
    assert code == 1
    assert "holds none of the wheels of the car" in wheels["sentence"]
    assert f"truck/{FOUR[0]}" in wheels["sentence"]
    (slip,) = [each for each in findings if each["subject"] == "wheel_slip"]
    assert "lacks wheel_states" in slip["sentence"]


def test_a_log_without_a_map_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.blf").write_bytes(b"LOGG")
    assert main([str(tmp_path / "log.blf")]) == 2
    assert "--map" in capsys.readouterr().err


def test_everything_else_in_the_vehicle_file_stays_comments_too(tmp_path: Path, car: Path) -> None:
    learned = {f"wheels.{name}.radius": (0.33, 0.0004) for name in FOUR}
    changed = with_values(CAR, {**learned, "accelerometer.bias": (0.2, 0.01), "accelerometer.sign": (-1.0, 0.0)})
    (tmp_path / "changed.yaml").write_text(changed)
    before, after = load_vehicle(car), load_vehicle(tmp_path / "changed.yaml")
    assert after.radii == (0.33,) * 4
    for old, new in zip(before.wheels, after.wheels, strict=True):
        assert new.deviations == {**old.deviations, "radius": Deviation(0.0004, SharedBy.WHEEL)}
        assert (new.name, new.joint, new.inertia, new.driven) == (old.name, old.joint, old.inertia, old.driven)
    assert (after.accelerometer.bias, after.accelerometer.sign) == (0.2, -1.0)
    assert (after.mass, after.deviations) == (before.mass, before.deviations)
    for comment in ("# it is mine", "# from the data sheet", "# worn", "# the new one", "# a comment below"):
        assert comment in changed
