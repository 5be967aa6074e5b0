"""Curves, and signals that are none, as the doctor examines them: dead wheels, error codes, senders of half a car."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import TwistWithCovarianceStamped
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState

from friction_bags.bag_io.bag_writer import write_bag
from friction_runtime.messages import from_nanoseconds
from vehicle_doctor.__main__ import main
from vehicle_doctor.findings import Finding, Verdict
from vehicle_doctor.learned_vehicle import learned_file
from vehicle_models.vehicle_file import load_vehicle

FOUR = ["front_left", "front_right", "rear_left", "rear_right"]
WHEELBASE, TRACK, RADIUS = 2.7, 1.5, 0.3
CAR = f"""\
name: my car
mass: {{value: 1500.0, stddev: 30.0}}
front_load_share: 0.5
wheelbase: {WHEELBASE}
centre_of_gravity_height: 0.5
track: {TRACK}
all_wheels: {{radius: {{value: {RADIUS}, stddev: 0.005}}, inertia: 1.0, brake_gain: 1.0e-4}}
wheels:
  front_left: {{axle: front, side: left}}
  front_right: {{axle: front, side: right}}
  rear_left: {{axle: rear, side: left, driven: true}}
  rear_right: {{axle: rear, side: right, driven: true}}
"""


@dataclass
class Said:
    """Answer of the doctor."""

    code: int
    findings: list[dict[str, Any]]

    def of(self, check: str, subject: str = "") -> list[dict[str, Any]]:
        return [each for each in self.findings if each["check"] == check and subject in ("", each["subject"])]


@pytest.fixture
def doctor(tmp_path: Path) -> Callable[..., Said]:
    (tmp_path / "car.yaml").write_text(CAR)

    def examine(messages: list[tuple[str, Any]], *options: str) -> Said:
        write_bag(tmp_path / "bag", messages, {})
        file = tmp_path / "findings.json"
        code = main(
            [str(tmp_path / "bag"), "--vehicle", str(tmp_path / "car.yaml"), "--json", str(file), *map(str, options)]
        )
        return Said(code, json.loads(file.read_text())["findings"])

    return examine


def wheel_speeds(speed: NDArray[np.float64], yaw_rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turning of wheels [rad/s], (N, 4), that roll where their axles take them; the rear ones do not slip sideways."""
    sides = np.array([1.0, -1.0, 1.0, -1.0]) * 0.5 * TRACK
    along = speed[:, None] - yaw_rate[:, None] * sides
    across = yaw_rate[:, None] * WHEELBASE * np.array([1.0, 1.0, 0.0, 0.0])
    return np.asarray(np.hypot(along, across) / RADIUS)


def drive(
    *, yaw_rate: float, seconds: float = 60.0, speed: float = 12.0, has_gyroscope: bool = True
) -> list[tuple[str, Any]]:
    """A car that turns steadily at changing speed, 100 Hz."""
    generator = np.random.default_rng(3)
    time = 0.01 * np.arange(round(100 * seconds))
    speeds = speed * (1.0 + 0.2 * np.sin(0.3 * time))
    rates = np.full_like(time, yaw_rate)
    wheels = wheel_speeds(speeds, rates) + 0.05 * generator.normal(size=(time.size, 4))
    messages: list[tuple[str, Any]] = []
    for k, at in enumerate(time):
        stamp = from_nanoseconds(round((1000.0 + at) * 1e9))
        states = JointState(name=FOUR, velocity=wheels[k].tolist())
        imu = Imu()
        states.header.stamp = imu.header.stamp = stamp
        imu.linear_acceleration.x = speed * 0.06 * np.cos(0.3 * at) + 0.05 * generator.normal()
        imu.angular_velocity.z = rates[k] + 0.005 * generator.normal()
        if not has_gyroscope:
            imu.angular_velocity_covariance[0] = -1.0
        messages += [("/wheel_states", states), ("/imu/data", imu)]
    return messages


@pytest.mark.parametrize("yaw_rate", [0.0, 0.05, 0.3, -0.3])
def test_a_steady_turn_is_no_difference_of_radii(doctor: Callable[..., Said], tmp_path: Path, yaw_rate: float) -> None:
    said = doctor(drive(yaw_rate=yaw_rate), "--write", tmp_path / "learned.yaml")
    radii = [each["value"] for each in said.of("radius")]
    assert radii == pytest.approx([RADIUS] * 4, rel=5e-3)
    assert all(each["verdict"] == "OK" for each in said.of("radius"))
    assert load_vehicle(tmp_path / "learned.yaml").radii == pytest.approx((RADIUS,) * 4, rel=5e-3)


def test_a_turn_of_which_nothing_tells_is_in_the_deviation(doctor: Callable[..., Said]) -> None:
    said = doctor(drive(yaw_rate=0.3, has_gyroscope=False))
    for each in said.of("radius"):
        assert abs(each["value"] - RADIUS) < 2.0 * each["stddev"]
        assert each["verdict"] == "OK"


@pytest.mark.parametrize(
    ("factor", "check", "word"), [(57.2958, "unit", "deg/s"), (-1.0, "exchanged", "the IMU turned")]
)
def test_a_yaw_rate_that_is_none_is_named(doctor: Callable[..., Said], factor: float, check: str, word: str) -> None:
    messages = drive(yaw_rate=0.0, seconds=40.0)
    time = 0.01 * np.arange(len(messages) // 2)
    turns = wheel_speeds(12.0 * (1.0 + 0.2 * np.sin(0.3 * time)), 0.2 * np.sin(0.5 * time))
    for k, at in enumerate(time):
        messages[2 * k][1].velocity = turns[k].tolist()
        messages[2 * k + 1][1].angular_velocity.z = factor * 0.2 * np.sin(0.5 * at)
    (finding,) = [each for each in doctor(messages).of(check) if each["subject"] != "wheel_states" or check != "unit"]
    assert finding["verdict"] == "FAIL"
    assert word in finding["sentence"]


def test_a_wheel_without_a_signal_leaves_the_others_to_be_examined(doctor: Callable[..., Said]) -> None:
    messages = drive(yaw_rate=0.0)
    for _, message in messages[::2]:
        message.velocity[2] = 0.0
        message.velocity[3] = 600.0
    said = doctor(messages)
    assert said.code == 1
    assert [each["subject"] for each in said.of("wheel")] == ["rear_left", "rear_right"]
    radii = {each["subject"]: each["value"] for each in said.of("radius")}
    assert radii == pytest.approx({"front_left": RADIUS, "front_right": RADIUS}, rel=5e-3)
    assert "inf" not in json.dumps(said.findings)


def test_two_seconds_of_an_error_code_are_left_out(doctor: Callable[..., Said]) -> None:
    messages = drive(yaw_rate=0.0)
    for _, message in messages[2000:2400:2]:
        message.velocity[1] = 182.04 / RADIUS
    said = doctor(messages)
    (code,) = said.of("signal", "wheel_states")
    assert "in 200 messages" in code["sentence"]
    assert [each["value"] for each in said.of("radius")] == pytest.approx([RADIUS] * 4, rel=5e-3)


def test_senders_of_two_wheels_each_are_named_and_examined(doctor: Callable[..., Said]) -> None:
    messages = []
    for topic, message in drive(yaw_rate=0.0):
        if topic == "/imu/data":
            messages.append((topic, message))
            continue
        for part in (slice(0, 2), slice(2, 4)):
            half = JointState(name=message.name[part], velocity=list(message.velocity)[part])
            half.header = message.header
            messages.append((topic, half))
    said = doctor(messages)
    (parts,) = [each for each in said.of("topic", "wheel_states") if "in parts" in each["sentence"]]
    assert parts["verdict"] == "FAIL"
    assert "front_left, front_right; rear_left, rear_right" in parts["sentence"]
    assert [each["value"] for each in said.of("radius")] == pytest.approx([RADIUS] * 4, rel=5e-3)
    assert "lacks wheel_states" in said.of("estimator", "wheel_slip")[0]["sentence"]


def test_wheels_that_turn_backwards_are_named_in_a_slow_drive_too(doctor: Callable[..., Said]) -> None:
    messages = drive(yaw_rate=0.0, speed=2.0)
    for _, message in messages[::2]:
        message.velocity = [-each for each in message.velocity]
    said = doctor(messages)
    assert [each["subject"] for each in said.of("sign")] == FOUR
    assert "never faster than 2.4 m/s" in said.of("motion")[0]["sentence"]


def test_a_speed_sensor_that_reads_zero_is_named_and_not_used(doctor: Callable[..., Said]) -> None:
    messages = drive(yaw_rate=0.0, seconds=20.0)
    for k in range(0, len(messages), 20):
        sensor = TwistWithCovarianceStamped()
        sensor.header.stamp = messages[k][1].header.stamp
        messages.append(("/vehicle_velocity", sensor))
    said = doctor(messages)
    assert said.of("speed", "vehicle_velocity")[0]["verdict"] == "FAIL"
    assert all("by the other wheels" in each["sentence"] for each in said.of("radius"))


def test_an_accelerometer_whose_noise_hides_the_drive_has_no_age(doctor: Callable[..., Said]) -> None:
    messages = drive(yaw_rate=0.0, speed=12.0)
    generator = np.random.default_rng(4)
    for _, message in messages[1::2]:
        message.linear_acceleration.x += 3.0 * generator.normal()
    for each in doctor(messages).findings:
        if each["check"] in ("skew", "scale") and each["subject"] == "imu/data":
            assert each["verdict"] == "OK"  # what is told is as wide as it must be


def test_without_pressures_the_curve_is_that_of_the_car(doctor: Callable[..., Said]) -> None:
    (curve,) = doctor(drive(yaw_rate=0.0, seconds=20.0)).of("estimator", "friction_curve_id")
    assert "one curve for the car" in curve["sentence"]


def test_what_no_car_can_have_is_not_written(tmp_path: Path) -> None:
    source = tmp_path / "car.yaml"
    source.write_text(CAR)
    learned = {
        "accelerometer.scale": (3.2, 1.1),
        "wheels.front_left.radius": (float("inf"), 0.1),
        "wheels.rear_left.radius": (0.301, 0.001),
    }
    text, left_out = learned_file([Finding("radius", "all", Verdict.WARN, "", learned=learned)], source)
    (tmp_path / "learned.yaml").write_text(text)
    assert load_vehicle(tmp_path / "learned.yaml").radii == (0.3, 0.3, 0.301, 0.3)
    (reason,) = left_out
    assert reason.startswith("accelerometer.scale = 3.2 ± 1.1 is not written: car.yaml: ")
