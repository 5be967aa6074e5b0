"""Wheel speeds are found by the names of joints, whatever else a message holds."""

from dataclasses import replace
from math import inf, isnan, nan

import pytest
from sensor_msgs.msg import JointState

from friction_runtime.wheel_speeds import WheelSpeeds
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

COMPACT = load_vehicle("compact_car")
JOINTS = {"front_left": "left", "front_right": "front-right"}
CAR: Vehicle = replace(
    COMPACT, wheels=tuple(replace(wheel, joint=JOINTS.get(wheel.name, wheel.name)) for wheel in COMPACT.wheels)
)
"""Its front wheels have other names in wheel_states."""
FRONT = ("front_left", "front_right")
REST = ["rear_left", "rear_right"]


class _Said:
    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, severity: str, text: str) -> None:
        self.texts.append(f"{severity}: {text}")


def test_wheels_are_found_by_joint_also_when_the_order_changes_between_messages() -> None:
    said = _Said()
    speeds = WheelSpeeds(CAR, FRONT, said)
    assert speeds.read(JointState(name=["front-right", "rear_left", "left"], velocity=[2.0, 9.0, 1.0])) == (1.0, 2.0)
    assert speeds.read(JointState(name=["left", "front-right"], velocity=[3.0, 4.0])) == (3.0, 4.0)
    assert speeds.read(JointState(name=["left", "front-right"], velocity=[5.0, -6.0])) == (5.0, -6.0)
    twice = JointState(name=["left", "front-right", "left"], velocity=[7.0, 8.0, 9.0])
    assert speeds.read(twice) == (7.0, 8.0), "of a name that stands twice the first counts"
    assert not said.texts


def test_all_wheels_are_read_in_the_order_that_was_asked_for() -> None:
    speeds = WheelSpeeds(CAR, ("rear_right", "front_left"), _Said())
    assert speeds.read(JointState(name=["left", *REST], velocity=[1.0, 3.0, 4.0])) == (4.0, 1.0)


@pytest.mark.parametrize(
    "message",
    [
        JointState(name=["left"], velocity=[1.0]),
        JointState(name=["left", "front-right"], velocity=[1.0]),
        JointState(name=["left", "front_right"], velocity=[1.0, 2.0]),
    ],
)
def test_a_missing_wheel_is_nan_and_named_with_what_is_there(message: JointState) -> None:
    said = _Said()
    left, right = WheelSpeeds(CAR, FRONT, said).read(message)
    assert left == 1.0
    assert isnan(right)
    (text,) = [text for text in said.texts if text.startswith("error")]
    assert text == (
        "error: wheel_states: no velocity for wheel 'front_right' (joint 'front-right'), names are: "
        f'"{", ".join(message.name)}"; check the vehicle file'
    )


def test_a_missing_wheel_without_a_joint_of_its_own_is_named_once() -> None:
    said = _Said()
    WheelSpeeds(CAR, ("rear_left",), said).read(JointState(name=["left"], velocity=[1.0]))
    (text,) = said.texts
    assert text.startswith("error: wheel_states: no velocity for wheel 'rear_left', names are: \"left\";")


def test_other_joints_are_noted_once_by_the_reader_of_the_first_wheel() -> None:
    said = _Said()
    readers = [WheelSpeeds(CAR, (name,), said) for name in CAR.wheel_names]
    for extra in (["steering"], ["steering", "mast"], ["steering"]):
        names = ["left", *extra, "front-right", *REST]
        message = JointState(name=names, velocity=[1.0] * len(names))
        assert [reader.read(message) for reader in readers] == [(1.0,)] * 4
    assert said.texts == ["info: wheel_states: not wheels of the car, ignored: steering"]


def test_messages_without_any_wheel_say_what_is_missing_and_nothing_else() -> None:
    said = _Said()
    WheelSpeeds(CAR, FRONT, said).read(JointState(name=["FL", "FR"], velocity=[1.0, 2.0]))
    assert len(said.texts) == 2
    assert all(text.startswith("error: ") and 'names are: "FL, FR";' in text for text in said.texts)


@pytest.mark.parametrize("garbage", [nan, inf, -inf, 1e4])
def test_garbage_is_nan_and_reported_and_the_other_wheel_goes_on(garbage: float) -> None:
    said = _Said()
    left, right = WheelSpeeds(CAR, FRONT, said).read(JointState(name=["left", "front-right"], velocity=[garbage, 7.0]))
    assert isnan(left)
    assert right == 7.0
    assert len(said.texts) == 1
    assert "wheel 'front_left' is not a wheel speed" in said.texts[0]
