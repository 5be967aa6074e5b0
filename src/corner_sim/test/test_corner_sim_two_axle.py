"""The two-axle car: load transfer and balances by hand, a reference integrator, the single corner as its limit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from corner_sim.corner import SingleCorner
from corner_sim.two_axle import TwoAxleCar, joint_acceleration, peak_torque, split_torque, wheel_loads
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle import Vehicle, four_wheels
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import axle_loads

CAR = load_vehicle("compact_car")
FLAT_AND_FREE = replace(CAR, centre_of_gravity_height=0.0, drag_area=0.0, rolling_resistance=0.0)


def with_wheels(car: Vehicle, radii: list[float], inertias: list[float]) -> Vehicle:
    wheels = [
        replace(wheel, radius=radius, inertia=inertia)
        for wheel, radius, inertia in zip(car.wheels, radii, inertias, strict=True)
    ]
    return replace(car, wheels=tuple(wheels))


def test_loads_by_hand() -> None:
    """1500 kg, 0.5 m over 2.7 m, -9 m/s^2: 2500 N go from the rear axle to the front."""
    loads = wheel_loads(CAR, -9.0)
    half = 0.25 * 1500.0 * 9.81
    assert loads == pytest.approx([half + 1250.0, half + 1250.0, half - 1250.0, half - 1250.0])


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(0.2, 0.8), st.floats(0.0, 0.4))
def test_acceleration_agrees_with_the_forces_of_the_loads_it_causes(
    front: float, rear: float, share: float, ratio: float
) -> None:
    a = joint_acceleration(front, rear, 0.3, share, ratio, 9.81)
    front_load, rear_load = axle_loads(a, 1500.0, share, ratio, 9.81)
    assert 1500.0 * float(a) == pytest.approx(
        -(float(front_load) * front + float(rear_load) * rear) - 1500.0 * 0.3, abs=1e-6
    )
    assert float(front_load + rear_load) == pytest.approx(1500.0 * 9.81)


def test_without_load_transfer_and_resistance_each_wheel_is_the_single_corner() -> None:
    corner = SingleCorner(CAR.corner("front_left"), [30.0])
    car = TwoAxleCar(FLAT_AND_FREE, [30.0])
    for k in range(80):
        begin, end = 1300.0 * min(k / 60, 1.0), 1300.0 * min((k + 1) / 60, 1.0)
        corner.step(begin, end, SURFACES["dry"], 0.005)
        car.step(begin, end, SURFACES["dry"], 0.005)
    assert car.speed == pytest.approx(corner.speed)
    assert car.wheel_speed[0] == pytest.approx(np.full(4, corner.wheel_speed[0]))
    assert car.distance == pytest.approx(corner.distance)


def test_braking_agrees_with_a_reference_integrator() -> None:
    theta, grade = SURFACES["wet"], 0.02
    torques = split_torque(CAR, np.array(2600.0))

    def derivative(time: float, state: np.ndarray) -> list[float]:
        v, omega = state[0], state[1:]
        mu = burckhardt.friction(theta, 1.0 - 0.3 * omega / v)
        drag = 0.5 * 1.2 * 0.65 * v**2 / 1500.0 + 9.81 * np.sin(grade)
        a = joint_acceleration((mu[0] + mu[1]) / 2, (mu[2] + mu[3]) / 2, drag, 0.5, 0.5 / 2.7, 9.81)
        loads = wheel_loads(CAR, a)
        return [float(a), *(0.3 * loads * (mu - 0.012) - torques * min(time / 0.25, 1.0))]

    reference = solve_ivp(derivative, (0.0, 0.5), [30.0, *[100.0] * 4], rtol=1e-10, atol=1e-10, max_step=0.005)
    car = TwoAxleCar(CAR, [30.0], grade=grade)
    for k in range(100):
        car.step(torques * min(k / 50, 1.0), torques * min((k + 1) / 50, 1.0), theta, 0.005)
    assert car.speed[0] == pytest.approx(reference.y[0, -1], abs=1e-5)
    assert car.wheel_speed[0] == pytest.approx(reference.y[1:, -1], abs=1e-3)


def test_error_falls_with_the_square_of_the_step() -> None:
    def final(max_step: float) -> float:
        car = TwoAxleCar(CAR, [30.0], max_step=max_step)
        for k in range(40):
            begin, end = split_torque(CAR, [100.0 * k]), split_torque(CAR, [100.0 * (k + 1)])
            car.step(begin, end, SURFACES["dry"], 0.005)
        return float(car.wheel_speed[0, 2])

    exact = final(2e-5)
    assert (final(2.5e-3) - exact) / (final(1.25e-3) - exact) == pytest.approx(4.0, abs=0.4)


def test_momentum_and_spin_balance_holds_over_a_stop() -> None:
    """m v + (J / r) sum omega changes by the impulse of brakes and slope alone, however the loads move."""
    car = TwoAxleCar(replace(CAR, drag_area=0.0, rolling_resistance=0.0), [25.0], grade=0.05)
    torques = np.array([500.0, 400.0, 300.0, 200.0])
    for _ in range(150):
        car.step(torques, torques, SURFACES["dry"], 0.005)
    start = 1500.0 * 25.0 + 4.0 / 0.3 * 25.0 / 0.3
    now = 1500.0 * car.speed[0] + car.wheel_speed[0].sum() / 0.3
    impulse = (torques.sum() / 0.3 + 1500.0 * 9.81 * np.sin(0.05)) * 0.75
    assert start - now == pytest.approx(impulse, rel=2e-3)


def test_peak_torque_holds_the_wheels_at_the_peak() -> None:
    theta = SURFACES["dry"]
    lambda_max, mu_max = burckhardt.peak(theta)
    bare = replace(CAR, drag_area=0.0, rolling_resistance=0.0)
    car = TwoAxleCar(bare, [20.0], wheel_speed=(1.0 - lambda_max) * 20.0 / 0.3)
    torque = peak_torque(bare, theta)
    assert car.acceleration(theta) == pytest.approx([-float(mu_max) * 9.81])
    held = (1.0 - float(lambda_max)) * -float(mu_max) * 9.81 / 0.3
    assert car.wheel_acceleration(theta, torque)[0] == pytest.approx(np.full(4, held))


def test_specific_force_is_what_a_standing_accelerometer_reads_on_a_slope() -> None:
    coasting = TwoAxleCar(replace(CAR, drag_area=0.0), [10.0], grade=0.02)
    assert coasting.acceleration(SURFACES["dry"]) == pytest.approx([-9.81 * np.sin(0.02)])
    assert coasting.specific_force(SURFACES["dry"]) == pytest.approx([0.0], abs=1e-12)


def test_drive_torque_pushes_the_rear_wheels_and_the_car() -> None:
    car = TwoAxleCar(CAR, [0.0])
    for _ in range(200):
        car.step(0.0, 0.0, SURFACES["dry"], 0.005, drive_torque=900.0)
    assert car.speed[0] == pytest.approx(1.0 * (900.0 / 0.3 - 0.012 * 1500.0 * 9.81) / (1500.0 + 4.0 / 0.09), rel=0.03)
    assert np.all(car.slip[0, 2:] < car.slip[0, :2])


@pytest.mark.parametrize("max_step", [1e-3, 5e-3])
@pytest.mark.parametrize("name", ["dry", "snow"])
def test_stop_with_and_without_lock_ends_at_rest_without_oscillation(name: str, max_step: float) -> None:
    car = TwoAxleCar(CAR, [4.0, 4.0], max_step=max_step)
    peak = peak_torque(CAR, SURFACES[name])
    torques = np.stack([0.7 * peak, 3.0 * peak])
    speeds = [car.speed]
    for _ in range(800):
        car.step(torques, torques, SURFACES[name], 0.005)
        speeds.append(car.speed)
        assert np.all(car.wheel_speed >= 0.0)
    assert np.all(np.diff(np.array(speeds), axis=0) <= 0.0)
    assert car.speed == pytest.approx([0.0, 0.0])
    assert car.wheel_speed == pytest.approx(np.zeros((2, 4)))


def test_locked_car_slides_with_the_friction_of_full_slip() -> None:
    bare = replace(CAR, drag_area=0.0)
    car = TwoAxleCar(bare, [20.0], wheel_speed=0.0)
    for _ in range(200):
        car.step(5000.0, 5000.0, SURFACES["dry"], 0.005)
    mu = float(burckhardt.friction(SURFACES["dry"], 1.0))
    assert car.speed[0] == pytest.approx(20.0 - mu * 9.81, rel=1e-9)
    assert car.slip[0] == pytest.approx(np.ones(4))


def test_runs_are_independent_of_each_other() -> None:
    roads = np.stack([SURFACES["dry"], SURFACES["snow"]])
    both = TwoAxleCar(CAR, [20.0, 15.0])
    alone = TwoAxleCar(CAR, [15.0])
    torques = np.array([[900.0, 900.0, 500.0, 500.0], [200.0, 200.0, 100.0, 100.0]])
    for _ in range(60):
        both.step(torques, torques, roads, 0.005)
        alone.step(torques[1], torques[1], SURFACES["snow"], 0.005)
    assert both.speed[1] == alone.speed[0]
    assert both.wheel_speed[1] == pytest.approx(alone.wheel_speed[0], abs=0.0)


UNEVEN = with_wheels(CAR, [0.3, 0.301, 0.32, 0.318], [1.0, 1.1, 1.4, 1.3])


def test_momentum_and_spin_balance_holds_with_wheels_that_differ() -> None:
    car = TwoAxleCar(replace(UNEVEN, drag_area=0.0, rolling_resistance=0.0), [25.0])
    radius, inertia = np.array(UNEVEN.radii), np.array([wheel.inertia for wheel in UNEVEN.wheels])
    torques = np.array([500.0, 400.0, 300.0, 200.0])
    start = 1500.0 * 25.0 + (inertia / radius * car.wheel_speed[0]).sum()
    for _ in range(150):
        car.step(torques, torques, SURFACES["dry"], 0.005)
    now = 1500.0 * car.speed[0] + (inertia / radius * car.wheel_speed[0]).sum()
    assert start - now == pytest.approx((torques / radius).sum() * 0.75, rel=2e-3)
    assert car.slip[0, 0] > car.slip[0, 1] > 0.0


def test_each_wheel_is_held_at_the_peak_by_its_own_torque() -> None:
    theta = SURFACES["wet"]
    lambda_max, mu_max = (float(each) for each in burckhardt.peak(theta))
    bare, radius = replace(UNEVEN, drag_area=0.0, rolling_resistance=0.0), np.array(UNEVEN.radii)
    car = TwoAxleCar(bare, [20.0], wheel_speed=(1.0 - lambda_max) * 20.0 / radius)
    assert car.slip[0] == pytest.approx(np.full(4, lambda_max))
    held = (1.0 - lambda_max) * -mu_max * 9.81 / radius
    assert car.wheel_acceleration(theta, peak_torque(bare, theta))[0] == pytest.approx(held)


def test_the_order_of_the_wheels_in_the_vehicle_does_not_matter() -> None:
    mixed = replace(UNEVEN, wheels=tuple(UNEVEN.wheels[k] for k in (3, 0, 2, 1)))
    assert four_wheels(mixed) == UNEVEN.wheels
    first, second = TwoAxleCar(UNEVEN, [30.0]), TwoAxleCar(mixed, [30.0])
    for car in (first, second):
        for _ in range(50):
            car.step([700.0, 600.0, 300.0, 200.0], [700.0, 600.0, 300.0, 200.0], SURFACES["dry"], 0.005)
    np.testing.assert_array_equal(first.wheel_speed, second.wheel_speed)


def test_brake_torque_splits_as_the_gains_and_the_engine_turns_what_it_drives() -> None:
    assert split_torque(CAR, [1000.0, 2000.0]) == pytest.approx(
        np.array([[325.0, 325.0, 175.0, 175.0], [650.0, 650.0, 350.0, 350.0]])
    )
    front_driven = replace(CAR, wheels=tuple(replace(each, driven=each.axle == "front") for each in CAR.wheels))
    none_driven = replace(CAR, wheels=tuple(replace(each, driven=False) for each in CAR.wheels))
    free, front, none = (TwoAxleCar(car, [10.0]) for car in (CAR, front_driven, none_driven))
    still = free.wheel_acceleration(SURFACES["dry"], 0.0)[0]
    assert front.wheel_acceleration(SURFACES["dry"], 0.0, 400.0)[0] - still == pytest.approx([200.0, 200.0, 0.0, 0.0])
    assert none.wheel_acceleration(SURFACES["dry"], 0.0, 400.0)[0] == pytest.approx(still)


def test_a_vehicle_that_is_no_car_with_four_wheels_is_refused_with_its_wheels() -> None:
    with pytest.raises(ValueError, match="'chapter corner' are front_left \\(front left\\)"):
        TwoAxleCar(load_vehicle("chapter_corner"), [30.0])
    with pytest.raises(ValueError, match="four wheels"):
        split_torque(replace(CAR, wheels=CAR.wheels[:3]), 100.0)


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match=r"'mass' = 0\.0 must be finite and > 0"):
        replace(CAR, mass=0.0)
    with pytest.raises(ValueError, match=r"'drag_area' = -1\.0 must be finite and >= 0"):
        replace(CAR, drag_area=-1.0)
    with pytest.raises(ValueError, match="front_load_share"):
        replace(CAR, front_load_share=1.0)
    with pytest.raises(ValueError, match="speed"):
        TwoAxleCar(CAR, [-1.0])
    with pytest.raises(ValueError, match="max_step"):
        TwoAxleCar(CAR, [1.0], max_step=0.0)
