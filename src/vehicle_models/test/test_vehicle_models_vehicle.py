"""The car: shares of the load, corners, the accelerometer, and invalid cars."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_models.vehicle import Accelerometer, CornerParameters, Wheel
from vehicle_models.vehicle_file import load_vehicle, vehicle_table
from vehicle_models.wheel_forces import axle_loads

CAR = replace(load_vehicle("compact_car"), front_load_share=0.58)


def reads(axis: str, value: float) -> SimpleNamespace:
    return SimpleNamespace(**{"x": 7.0, "y": -7.0, "z": 9.81, axis: value})


def test_load_shares_are_those_of_the_axles_divided_by_their_wheels() -> None:
    assert CAR.load_shares == pytest.approx((0.29, 0.29, 0.21, 0.21))
    three = replace(CAR, wheels=CAR.wheels[1:])
    assert three.load_shares == pytest.approx((0.58, 0.21, 0.21))


@given(st.floats(-9.0, 4.0))
def test_transfer_shares_move_the_load_that_load_transfer_says(acceleration: float) -> None:
    shares = np.array(CAR.load_shares) - np.array(CAR.transfer_shares) * acceleration / 9.81
    front, rear = axle_loads(acceleration, CAR.mass, 0.58, CAR.height_ratio, 9.81)
    assert CAR.mass * 9.81 * shares == pytest.approx([front / 2, front / 2, rear / 2, rear / 2])


def test_a_corner_is_a_wheel_with_the_mass_that_rests_on_it() -> None:
    wheels = (replace(CAR.wheels[0], radius=0.31, inertia=1.2), *CAR.wheels[1:])
    car = replace(CAR, wheels=wheels)
    assert car.corner("front_left") == CornerParameters(0.31, 1.2, 1500.0 * 0.29, 1500.0 * 0.29 * 9.81)
    with pytest.raises(KeyError, match="no wheel 'middle', it has front_left, front_right"):
        car.corner("middle")


@pytest.mark.parametrize(
    ("mounting", "reading", "acceleration"),
    [
        (Accelerometer(), reads("x", -4.0), -4.0),
        (Accelerometer(axis="y"), reads("y", -4.0), -4.0),
        (Accelerometer(axis="z", sign=-1.0), reads("z", 4.0), -4.0),
        (Accelerometer(bias=0.5), reads("x", -3.5), -4.0),
        (Accelerometer(sign=-1.0, bias=0.5), reads("x", 3.5), -4.0),
        (Accelerometer(scale=1.25), reads("x", -5.0), -4.0),
        # 4 m/s^2 bring the nose down by 0.02 rad, which adds 0.02 g to the reading
        (Accelerometer(pitch_gain=0.005), reads("x", -4.0 - 9.81 * 0.02), -4.0),
        (Accelerometer("y", -1.0, 0.3, 0.9, 0.01), reads("y", 0.9 * (1.0 + 0.0981) * 4.0 - 0.3), -4.0),
    ],
)
def test_forward_acceleration_by_hand(mounting: Accelerometer, reading: SimpleNamespace, acceleration: float) -> None:
    assert mounting.forward(reading) == pytest.approx(acceleration, rel=1e-12)


@given(
    st.sampled_from("xyz"),
    st.sampled_from([-1.0, 1.0]),
    st.floats(-20.0, 20.0),
    st.floats(0.5, 2.0),
    st.floats(0.0, 0.02),
    st.floats(-20.0, 20.0),
)
def test_reading_is_the_inverse_of_forward(
    axis: str, sign: float, offset: float, scale: float, pitch_gain: float, acceleration: float
) -> None:
    mounting = Accelerometer(axis, sign, offset, scale, pitch_gain)
    assert mounting.forward(reads(axis, mounting.reading(acceleration))) == pytest.approx(acceleration, abs=1e-12)


@given(st.floats(-200.0, 200.0))
def test_a_plain_mounting_changes_no_bit_of_a_reading(acceleration: float) -> None:
    assert Accelerometer().forward(reads("x", acceleration)) == acceleration
    assert Accelerometer().reading(acceleration) == acceleration


def test_a_wheel_without_its_values_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="'radius' = nan must be finite and > 0"):
        Wheel("FL", "FL")


@pytest.mark.parametrize("name", ["mass", "wheelbase", "track"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_value_is_refused_however_the_car_is_made(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"'{name}' = {value} must be finite and > 0"):
        replace(CAR, **{name: value})  # type: ignore[arg-type]


def test_what_makes_no_car_is_refused() -> None:
    first, *others = CAR.wheels
    for wheels, said in (
        ((), "at least one wheel"),
        ((first, replace(others[0], name=first.name), *others[1:]), "two have the name 'front_left'"),
        ((first, replace(others[0], joint=first.joint), *others[1:]), "two have the joint 'front_left'"),
        ((first, replace(others[0], side="left"), *others[1:]), "two have the place 'front left'"),
        (tuple(others[1:]), "none is on the axle 'front'"),
    ):
        with pytest.raises(ValueError, match=f"'wheels'.*{said}"):
            replace(CAR, wheels=wheels)
    with pytest.raises(ValueError, match=r"'sign' = 0\.5 must be 1 or -1"):
        Accelerometer(sign=0.5)


def test_the_readme_holds_the_table_of_the_keys() -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    assert f"<!-- vehicle -->\n\n{vehicle_table()}\n<!-- /vehicle -->\n" in readme
    assert all(f"`{part}`" in readme for part in ("name", "joint", "all_wheels", "axles", "stddev"))
