"""Friction in use of car, axles and wheels: by accelerometer, brakes, spinning wheels and the turning car."""

from math import isnan, nan

import numpy as np
import pytest

from friction_grip.friction_used import FrictionUsed, GripInUse
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
NO_TORQUE = (0.0, 0.0, 0.0, 0.0)
UNREAD = (nan, nan, nan, nan)


def asked(deceleration: float, shares: tuple[float, ...]) -> tuple[float, ...]:
    """Brake torques [N m] that give a deceleration [m/s^2] by these shares."""
    return tuple(
        CAR.mass * deceleration * share * wheel.radius for share, wheel in zip(shares, CAR.wheels, strict=True)
    )


def used_in(
    forward: float,
    torques: tuple[float, ...],
    leftward: float = nan,
    turning: float = nan,
    spins: tuple[float, ...] = NO_TORQUE,
    vehicle: Vehicle = CAR,
) -> GripInUse:
    """Friction in use at 5 m/s, where drag is little; `forward`: by the slip of the tyres; rates [rad/s^2]."""
    read = forward - GRAVITY * vehicle.rolling_resistance
    estimator, found = FrictionUsed(vehicle), None
    for k in range(1, 101):
        time = 0.005 * k
        speeds = [16.0 + spin * time for spin in spins]
        answer = estimator.update(k * 5_000_000, 5.0, read, leftward, 0.1 + turning * time, torques, speeds)
        found = answer or found
    assert found is not None
    return found


def forces(grip: GripInUse) -> np.ndarray:
    """Forces of the wheels over the mass [m/s^2], by the loads of a car that only pitches."""
    shares = np.array(CAR.load_shares) + np.array(CAR.transfer_shares) * grip.vehicle.mu_x
    return GRAVITY * shares * np.array([wheel.mu_x for wheel in grip.wheels])


@pytest.mark.parametrize("forward", [-6.0, -2.0, -0.3])
def test_wheels_brake_as_the_car_slows_down(forward: float) -> None:
    grip = used_in(forward, asked(-forward, (0.35, 0.35, 0.15, 0.15)))
    assert forces(grip).sum() == pytest.approx(-forward, rel=0.02, abs=0.02)
    assert grip.vehicle.mu_used == pytest.approx(-forward / GRAVITY, abs=2.0 * grip.vehicle.stddev)
    assert grip.wheels[0].mu_used == pytest.approx(grip.front.mu_used, abs=0.01)


def test_each_wheel_of_a_split_road_has_its_own_friction() -> None:
    grip = used_in(-4.0, asked(4.0, (0.6, 0.1, 0.25, 0.05)))
    left, right = grip.wheels[0], grip.wheels[1]
    assert left.mu_used > 4.0 * right.mu_used
    assert left.mu_used - 2.58 * left.stddev > grip.front.mu_used > right.mu_used + 2.58 * right.stddev


def test_a_wheel_that_is_slowed_down_brakes_less_than_its_torque() -> None:
    torques = asked(4.0, (0.35, 0.35, 0.15, 0.15))
    rolls = used_in(-4.0, torques)
    slides = used_in(-4.0, (3.0 * torques[0], *torques[1:]), spins=(-2.0 * torques[0] / CAR.wheels[0].inertia, 0, 0, 0))
    assert slides.wheels[0].mu_used == pytest.approx(rolls.wheels[0].mu_used, abs=0.04)
    assert slides.wheels[0].stddev > rolls.wheels[0].stddev


def test_brakes_that_contradict_the_accelerometer_are_known_less() -> None:
    agree = used_in(-4.0, asked(4.0, (0.35, 0.35, 0.15, 0.15)))
    for share in (0.0, 0.5, 2.0):
        grip = used_in(-4.0, asked(4.0 * share, (0.35, 0.35, 0.15, 0.15)))
        assert grip.vehicle.mu_used == pytest.approx(agree.vehicle.mu_used, abs=0.02)
        assert grip.front.stddev > 1.5 * agree.front.stddev
        assert abs(grip.front.mu_used - agree.front.mu_used) < 2.0 * grip.front.stddev


def test_the_engine_drives_the_driven_axle() -> None:
    grip = used_in(2.0, NO_TORQUE)
    assert grip.front.mu_used < 0.01
    assert grip.rear.mu_x * _load_of_rear(grip) == pytest.approx(grip.vehicle.mu_x, rel=0.02)
    assert grip.vehicle.mu_x == pytest.approx(-2.0 / GRAVITY, abs=0.02)


def _load_of_rear(grip: GripInUse) -> float:
    return float(np.array(CAR.load_shares)[2:].sum() + np.array(CAR.transfer_shares)[2:].sum() * grip.vehicle.mu_x)


def test_a_wheel_without_a_pressure_is_not_known_and_its_axle_is_known_less() -> None:
    all_known = used_in(-4.0, asked(4.0, (0.35, 0.35, 0.15, 0.15)))
    one_missing = used_in(-4.0, (nan, *asked(4.0, (0.35, 0.35, 0.15, 0.15))[1:]))
    none = used_in(-4.0, UNREAD)
    assert isnan(one_missing.wheels[0].mu_used)
    assert one_missing.front.mu_used == pytest.approx(all_known.front.mu_used, abs=2.0 * one_missing.front.stddev)
    assert one_missing.front.stddev > all_known.front.stddev
    assert all(isnan(wheel.mu_used) for wheel in none.wheels)
    assert none.vehicle.mu_used == pytest.approx(all_known.vehicle.mu_used, abs=0.01)


def test_a_car_that_begins_to_turn_uses_more_at_the_front() -> None:
    steady, turning, unknown = (used_in(0.0, NO_TORQUE, 3.0, rate) for rate in (0.0, 1.0, nan))
    assert steady.front.mu_used == pytest.approx(steady.rear.mu_used, abs=0.02)
    ahead = CAR.wheelbase * (1.0 - CAR.front_load_share)
    assert turning.front.mu_y - steady.front.mu_y == pytest.approx(ahead / GRAVITY, rel=0.05)
    assert turning.vehicle.mu_y == pytest.approx(steady.vehicle.mu_y)
    assert unknown.front.stddev > steady.front.stddev


def test_what_the_accelerometer_does_not_say_is_not_known() -> None:
    grip = used_in(nan, NO_TORQUE)
    assert all(isnan(part.mu_used) for part in (grip.vehicle, grip.front, grip.rear, *grip.wheels))


def test_a_single_corner_has_no_rear_axle() -> None:
    corner = load_vehicle("chapter_corner")
    grip = used_in(-3.0, (corner.mass * 3.0 * corner.radii[0],), spins=(0.0,), vehicle=corner)
    assert grip.front.mu_used == pytest.approx(grip.vehicle.mu_used, abs=0.01)
    assert isnan(grip.rear.mu_used)
