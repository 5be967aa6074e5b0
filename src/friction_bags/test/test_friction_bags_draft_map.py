"""Signals of logs listed, and maps drafted from their names, for names as many tools and cars have them."""

from pathlib import Path

import pytest
import yaml
from sensor_msgs.msg import JointState

from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.importers.draft_map import draft_map
from friction_bags.importers.signal_list import ListedSignal, list_signals
from friction_runtime.messages import from_nanoseconds

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def drafted(names: list[str], source: str = "table", kind: str = "") -> dict[str, object]:
    signals = [ListedSignal(name, source, kind) for name in names]
    return dict(yaml.safe_load(draft_map(signals, Path("drive.csv"), "compact_car", None)[0]))


@pytest.mark.parametrize(
    "names",
    [
        ["w_fl", "w_fr", "w_rl", "w_rr"],
        ["WHL_SPD11.WHL_SPD_FL", "WHL_SPD11.WHL_SPD_FR", "WHL_SPD11.WHL_SPD_RL", "WHL_SPD11.WHL_SPD_RR"],
        ["WheelSpeedFrontLeft", "WheelSpeedFrontRight", "WheelSpeedRearLeft", "WheelSpeedRearRight"],
        ["Wheel Speed LF [km/h]", "Wheel Speed RF [km/h]", "Wheel Speed LR [km/h]", "Wheel Speed RR [km/h]"],
        ["v_VL", "v_VR", "v_HL", "v_HR"],
        ["wheel_fl(kmph)", "wheel_fr(kmph)", "wheel_rl(kmph)", "wheel_rr(kmph)"],
    ],
)
def test_wheels_are_found_by_their_names(names: list[str]) -> None:
    others = ["brake_temp_fl", "brake_temp_fr", "brake_temp_rl", "brake_temp_rr", "tire_pressure_fl", "gear"]
    found = drafted([*others, *names])["signals"]
    assert list(found) == ["wheel_speed"]  # type: ignore[call-overload]
    assert found["wheel_speed"]["fields"] == dict(zip(WHEELS, names, strict=True))  # type: ignore[index]


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("ax_mps2", "acceleration"),
        ("KINEMATICS.ACCEL_Y", "lateral_acceleration"),
        ("LongAcc", "acceleration"),
        ("ESP12.LONG_ACCEL", "acceleration"),
        ("ESP12.YAW_RATE", "yaw_rate"),
        ("YawRate [deg/s]", "yaw_rate"),
        ("vx(m/s)", "speed"),
        ("GPS_Speed", "speed"),
        ("BrakePressure", "brake_demand"),
        ("ESP12.CYL_PRES", "brake_demand"),
        ("steering_angle", None),
        ("pitch_rad", None),
        ("engine_rpm", None),
        ("LONG_ACCEL_STATUS", None),
    ],
)
def test_signals_of_the_car_are_found_by_their_names(name: str, quantity: str | None) -> None:
    names = [name] if quantity not in ("lateral_acceleration", "yaw_rate") else [name, "a_long_acc"]
    found = drafted(names)["signals"] or {}
    if quantity is None:
        assert not found
    else:
        entry = found[quantity]["from"]  # type: ignore[index]
        assert name in entry.values()


def test_a_unit_in_a_name_is_taken_and_one_that_is_not_stated_is_doubted() -> None:
    text, _ = draft_map(
        [ListedSignal(f"wheel_{each}(kmph)", "table") for each in ("fl", "fr", "rl", "rr")]
        + [ListedSignal("ax", "table")],
        Path("drive.csv"),
        "",
        None,
    )
    assert "unit: km/h\n" in text
    assert "unit: m/s^2   # not stated in the log" in text
    assert "vehicle: my_car.yaml" in text
    assert 'stamp: "wheel_fl(kmph)"   # the column of the time' in text


def test_the_signals_of_a_table_have_rates_and_ranges(tmp_path: Path) -> None:
    rows = "".join(f"{10 * k},{k % 5},{'' if k % 2 else 3}\n" for k in range(200))
    (tmp_path / "drive.csv").write_text(f"Time [ms],a,slow\n{rows}")
    found = {each.name: each for each in list_signals(tmp_path / "drive.csv", None)}
    assert found["a"].rate == pytest.approx(100.0)
    assert (found["a"].low, found["a"].high) == (0.0, 4.0)
    assert found["slow"].rate == pytest.approx(50.0)


def test_the_wheels_of_a_bag_are_drafted_by_their_joints(tmp_path: Path) -> None:
    names = ["wheel_fl", "wheel_fr", "wheel_rl", "wheel_rr"]
    states = [JointState(name=names, velocity=[30.0] * 4, position=[0.0] * 4) for _ in range(50)]
    for k, state in enumerate(states):
        state.header.stamp = from_nanoseconds((k + 1) * 10_000_000)
    write_bag(tmp_path / "bag", [("/joint_states", state) for state in states], {})
    signals = list_signals(tmp_path / "bag", None)
    found = yaml.safe_load(draft_map(signals, tmp_path / "bag", "compact_car", None)[0])["signals"]
    assert found["wheel_speed"]["from"] == {"topic": "/joint_states", "type": "sensor_msgs/msg/JointState"}
    assert found["wheel_speed"]["fields"]["rear_left"] == "velocity[name=wheel_rl]"
