"""Brake torque from pressure: gain of the wheel, delay of the signal, garbage refused."""

from dataclasses import replace
from math import inf, nan

import pytest
from builtin_interfaces.msg import Time
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Header

from friction_runtime.brake_torque import BrakeTorque
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

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
