"""Wheel speeds are found by the names of joints, whatever else a message holds."""

from dataclasses import replace
from math import inf, isnan, nan

import pytest
from builtin_interfaces.msg import Time
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from friction_runtime.wheel_inputs import BrakeTorque, WheelSpeeds
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


STAMP = 5_000_000_100


def pressure(value: float) -> FluidPressure:
    return FluidPressure(header=Header(stamp=Time(sec=5, nanosec=100)), fluid_pressure=value)


def car(gain: float = 1e-4, delay: float = 0.0) -> Vehicle:
    made = load_vehicle("compact_car")
    front, *rest = made.wheels
    return replace(made, wheels=(replace(front, brake_gain=gain), *rest), brake_pressure_delay=delay)


def test_torque_is_the_gain_of_the_wheel_times_the_pressure() -> None:
    vehicle = car(gain=2e-4)
    assert BrakeTorque(vehicle, "front_left").read(pressure(5e6)) == (STAMP, 2e-4 * 5e6)
    other = vehicle.wheel("rear_right").brake_gain
    assert BrakeTorque(vehicle, "rear_right").read(pressure(5e6)) == (STAMP, other * 5e6)
    assert BrakeTorque(vehicle, "rear_right").topic == "rear_right/brake_pressure"


def test_a_pressure_acted_before_its_stamp_by_the_delay_of_the_signal() -> None:
    assert BrakeTorque(car(delay=0.025), "front_left").read(pressure(1e6)) == (STAMP - 25_000_000, 1e-4 * 1e6)


def test_a_small_negative_pressure_is_an_offset_of_the_sensor_and_taken() -> None:
    assert BrakeTorque(car(), "front_left").read(pressure(-1e4)) == (STAMP, -1.0)


@pytest.mark.parametrize("value", [nan, inf, -inf, 1.1e8, -1.1e8])
def test_what_is_no_pressure_is_refused_by_topic(value: float) -> None:
    assert BrakeTorque(car(), "front_left").read(pressure(value)) == (
        f"front_left/brake_pressure: {value} Pa is not a brake pressure"
    )


def test_a_pressure_of_another_topic_is_judged_alike() -> None:
    brake = BrakeTorque(car(delay=0.025), "front_left")
    assert brake.torque("brake_demand", 5e6) == 1e-4 * 5e6
    assert brake.torque("brake_demand", nan) == "brake_demand: nan Pa is not a brake pressure"


def test_a_pressure_whose_torque_no_brake_has_is_refused() -> None:
    assert isinstance(BrakeTorque(car(gain=1.0), "front_left").read(pressure(2e5)), str)
