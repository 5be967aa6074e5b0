"""Wheel speeds are found by name, whatever else a message holds."""

from math import inf, isnan, nan

import pytest
from sensor_msgs.msg import JointState

from friction_runtime.wheel_speeds import WheelSpeeds


class _Said:
    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, severity: str, text: str) -> None:
        self.texts.append(f"{severity}: {text}")


def test_wheels_are_found_by_name_also_when_the_order_changes_between_messages() -> None:
    said = _Said()
    speeds = WheelSpeeds(("left", "right"), said)
    assert speeds.read(JointState(name=["right", "steering", "left"], velocity=[2.0, 9.0, 1.0])) == (1.0, 2.0)
    assert speeds.read(JointState(name=["left", "right"], velocity=[3.0, 4.0])) == (3.0, 4.0)
    assert speeds.read(JointState(name=["left", "right"], velocity=[5.0, -6.0])) == (5.0, -6.0)
    assert speeds.read(JointState(name=["left", "right", "left"], velocity=[7.0, 8.0, 9.0])) == (7.0, 8.0)
    assert not said.texts


@pytest.mark.parametrize(
    "message",
    [
        JointState(name=["left"], velocity=[1.0]),
        JointState(name=["left", "right"], velocity=[1.0]),
        JointState(name=["left", "wrong"], velocity=[1.0, 2.0]),
    ],
)
def test_a_missing_wheel_is_nan_and_named_with_what_is_there(message: JointState) -> None:
    said = _Said()
    left, right = WheelSpeeds(("left", "right"), said).read(message)
    assert left == 1.0
    assert isnan(right)
    (text,) = said.texts
    assert text.startswith("error: wheel_states: no velocity for wheel 'right'")
    assert ", ".join(message.name) in text


@pytest.mark.parametrize("garbage", [nan, inf, -inf, 1e4])
def test_garbage_is_nan_and_reported_and_the_other_wheel_goes_on(garbage: float) -> None:
    said = _Said()
    left, right = WheelSpeeds(("left", "right"), said).read(JointState(name=["left", "right"], velocity=[garbage, 7.0]))
    assert isnan(left)
    assert right == 7.0
    assert len(said.texts) == 1
    assert "wheel 'left' is no wheel speed" in said.texts[0]
