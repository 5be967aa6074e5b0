"""Vertical load of a wheel from the acceleration: what rests, what moves, and how it moves."""

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle, shipped_vehicles
from vehicle_models.wheel_forces import LEAST_SHARE, WheelLoad, axle_loads

CAR = replace(load_vehicle("compact_car"), front_load_share=0.58)
MS = 1_000_000


def of_axles(acceleration: float) -> list[float]:
    axles = axle_loads(acceleration, CAR.mass, CAR.front_load_share, CAR.height_ratio, GRAVITY)
    return [0.5 * float(load) for load in axles for _ in range(2)]


def loads(car: Vehicle) -> list[WheelLoad]:
    return [WheelLoad(car, name) for name in car.wheel_names]


def fed(load: WheelLoad, acceleration: list[float], step: int = 5 * MS) -> WheelLoad:
    for k, value in enumerate(acceleration):
        load.update((k + 1) * step, value)
    return load


@pytest.mark.parametrize("name", shipped_vehicles())
def test_loads_at_rest_carry_the_weight(name: str) -> None:
    car = load_vehicle(name)
    assert sum(load.load for load in loads(car)) == pytest.approx(car.mass * GRAVITY)


def test_steady_braking_moves_m_a_h_over_l_to_the_front_axle() -> None:
    found = [fed(load, [-6.0] * 2000).load for load in loads(CAR)]
    moved = CAR.mass * 6.0 * CAR.centre_of_gravity_height / CAR.wheelbase
    assert found[0] + found[1] == pytest.approx(CAR.mass * GRAVITY * 0.58 + moved)
    assert sum(found) == pytest.approx(CAR.mass * GRAVITY)
    np.testing.assert_allclose(found, of_axles(-6.0))


@given(
    frequency=st.floats(0.5, 5.0),
    damping=st.floats(0.05, 0.95),
    step=st.sampled_from([1, 5, 20]),
    samples=st.integers(1, 60),
)
def test_step_of_the_acceleration_is_answered_as_a_damped_oscillation(
    frequency: float, damping: float, step: int, samples: int
) -> None:
    car = replace(CAR, pitch_frequency=frequency, pitch_damping=damping)
    load = WheelLoad(car, "front_left")
    load.update(1, 0.0)
    load.update(2, -5.0)  # within a nanosecond: a step
    start = load.load
    for k in range(samples):
        load.update(2 + (k + 1) * step * MS, -5.0)
    t, w = samples * step * 1e-3, 2.0 * pi * frequency
    damped = w * sqrt(1.0 - damping**2)
    left = exp(-damping * w * t) * (cos(damped * t) + damping * w / damped * sin(damped * t))
    moved = 0.5 * car.mass * 5.0 * car.height_ratio
    assert start == pytest.approx(load.at_rest, rel=1e-6)
    assert load.load == pytest.approx(load.at_rest + moved * (1.0 - left), rel=1e-6)
    rate = moved * exp(-damping * w * t) * w * w / damped * sin(damped * t)
    assert load.rate == pytest.approx(rate, abs=1e-3 * moved)


def test_ramp_is_exact_whatever_the_sample_time() -> None:
    fine = fed(WheelLoad(CAR, "rear_left"), [-20.0 * k * 0.001 for k in range(401)], MS)
    coarse = fed(WheelLoad(CAR, "rear_left"), [-20.0 * k * 0.1 for k in range(5)], 100 * MS)
    assert coarse.load == pytest.approx(fine.load)
    assert coarse.rate == pytest.approx(fine.rate)
    assert coarse.rate < 0.0


def test_first_acceleration_is_taken_to_have_lasted() -> None:
    load = fed(WheelLoad(CAR, "front_left"), [-4.0])
    assert load.load == pytest.approx(of_axles(-4.0)[0])
    assert load.rate == 0.0
    load.update(20 * MS, -9.0)
    load.reset()
    assert (load.load, load.rate) == (load.at_rest, 0.0)


def test_corner_alone_keeps_its_load() -> None:
    car = load_vehicle("chapter_corner")
    load = fed(WheelLoad(car, "front_left"), [0.0, -9.0, -9.0])
    assert (load.transfer, load.load, load.rate) == (0.0, load.at_rest, 0.0)


def test_load_stays_positive_under_an_acceleration_that_would_lift_the_wheel() -> None:
    load = fed(WheelLoad(CAR, "rear_left"), [-60.0] * 100)
    assert load.load == pytest.approx(LEAST_SHARE * load.at_rest)
