"""Single-corner dynamics (2.15): against a reference integrator, conservation laws and the behaviour at its limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from corner_sim.corner import SingleCorner
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1
from vehicle_models.vehicle_file import load_vehicle

CORNER = load_vehicle("chapter_corner").corner("front_left")


def ramp_and_hold(time: float, peak: float) -> float:
    return peak * min(time / 0.25, 1.0)


@pytest.mark.parametrize("name", TABLE_8_1)
def test_braking_agrees_with_a_reference_integrator(name: str) -> None:
    theta = SURFACES[name]
    hold = 1.02 * float(CORNER.peak_torque(theta))

    def derivative(time: float, state: np.ndarray) -> list[float]:
        v, omega = state
        force = CORNER.vertical_load * float(burckhardt.friction(theta, (v - omega * CORNER.radius) / v))
        return [-force / CORNER.mass, (CORNER.radius * force - ramp_and_hold(time, hold)) / CORNER.inertia]

    reference = solve_ivp(derivative, (0.0, 0.5), [30.0, 100.0], rtol=1e-10, atol=1e-10, max_step=0.005)
    corner = SingleCorner(CORNER, [30.0])
    for k in range(100):
        corner.step(ramp_and_hold(0.005 * k, hold), ramp_and_hold(0.005 * (k + 1), hold), theta, 0.005)
    assert corner.speed[0] == pytest.approx(reference.y[0, -1], abs=1e-4)
    assert corner.wheel_speed[0] == pytest.approx(reference.y[1, -1], abs=2e-2)


def test_error_falls_with_the_square_of_the_step() -> None:
    theta = SURFACES["dry"]

    def final_slip(max_step: float) -> float:
        corner = SingleCorner(CORNER, [30.0], max_step=max_step)
        for k in range(60):
            corner.step(3000.0 * 0.005 * k, 3000.0 * 0.005 * (k + 1), theta, 0.005)
        return float(corner.slip[0])

    exact = final_slip(1e-5)
    ratio = (final_slip(1e-3) - exact) / (final_slip(5e-4) - exact)
    assert 3.0 < ratio < 5.0


def test_momentum_and_spin_balance_holds_over_a_stop() -> None:
    """m v + (J / r) omega changes by the impulse of the brake alone: friction is internal to the sum."""
    corner = SingleCorner(CORNER, [20.0])
    torque = 500.0
    for _ in range(150):
        corner.step(torque, torque, SURFACES["wet"], 0.005)
    start = CORNER.mass * 20.0 + CORNER.inertia / CORNER.radius * 20.0 / CORNER.radius
    now = CORNER.mass * corner.speed[0] + CORNER.inertia / CORNER.radius * corner.wheel_speed[0]
    assert start - now == pytest.approx(torque / CORNER.radius * 0.75, rel=1e-9)


def test_free_rolling_corner_keeps_its_speed() -> None:
    corner = SingleCorner(CORNER, [12.0])
    for _ in range(200):
        corner.step(0.0, 0.0, SURFACES["dry"], 0.005)
    assert corner.speed[0] == pytest.approx(12.0, rel=1e-12)
    assert corner.distance[0] == pytest.approx(12.0, rel=1e-12)


def test_stop_is_smooth_down_to_rest_and_stays_there() -> None:
    theta = np.repeat(np.stack([SURFACES[name] for name in TABLE_8_1]), 3, axis=0)
    torque = np.tile([0.5, 0.95, 1.5], 4) * CORNER.peak_torque(theta)
    corner = SingleCorner(CORNER, np.full(12, 5.0))
    last = corner.speed
    for _ in range(1500):
        corner.step(torque, torque, theta, 0.005)
        assert np.all((corner.speed >= 0.0) & (corner.speed <= last))
        assert np.all((corner.wheel_speed >= 0.0) & (corner.wheel_speed * CORNER.radius <= corner.speed + 1e-2))
        last = corner.speed
    assert np.all(corner.speed == 0.0)
    assert np.all(corner.wheel_speed == 0.0)


def test_torque_far_above_the_peak_locks_the_wheel_without_turning_it_backwards() -> None:
    corner = SingleCorner(CORNER, [30.0])
    for _ in range(100):
        corner.step(3000.0, 3000.0, SURFACES["wet"], 0.005)
        assert corner.wheel_speed[0] >= 0.0
    assert corner.slip[0] == 1.0
    assert corner.wheel_acceleration(SURFACES["wet"], 3000.0)[0] == 0.0


def test_locked_wheel_slows_the_car_by_its_sliding_friction_alone() -> None:
    theta = SURFACES["wet"]
    corner = SingleCorner(CORNER, [30.0], [0.0])
    for _ in range(100):
        corner.step(3000.0, 3000.0, theta, 0.005)
    sliding = float(burckhardt.friction(theta, 1.0)) * CORNER.gravity
    assert corner.speed[0] == pytest.approx(30.0 - 0.5 * sliding, rel=1e-12)


def test_peak_torque_holds_the_wheel_at_the_peak() -> None:
    theta = SURFACES["dry"]
    lambda_max, _ = burckhardt.peak(theta)
    corner = SingleCorner(CORNER, [30.0], [30.0 * (1.0 - lambda_max) / CORNER.radius])
    slip_wheel_rate = corner.wheel_acceleration(theta, CORNER.peak_torque(theta))
    assert slip_wheel_rate == pytest.approx((1.0 - lambda_max) * corner.acceleration(theta) / CORNER.radius, rel=1e-9)


def test_many_runs_at_once_equal_the_same_runs_one_by_one() -> None:
    theta = np.stack([SURFACES[name] for name in TABLE_8_1])
    together = SingleCorner(CORNER, np.full(4, 30.0))
    torque = 0.9 * CORNER.peak_torque(theta)
    for _ in range(50):
        together.step(torque, torque, theta, 0.005)
    for k in range(4):
        alone = SingleCorner(CORNER, [30.0])
        for _ in range(50):
            alone.step(torque[k], torque[k], theta[k], 0.005)
        assert alone.slip[0] == together.slip[k]


def test_corners_with_parameters_of_their_own_equal_the_same_corners_one_by_one() -> None:
    own = [CORNER, replace(CORNER, radius=0.32, inertia=1.4), replace(CORNER, mass=300.0, vertical_load=2500.0)]
    together = SingleCorner(own, np.full(3, 30.0))
    for _ in range(60):
        together.step(500.0, 500.0, SURFACES["dry"], 0.005)
    for k, parameters in enumerate(own):
        alone = SingleCorner(parameters, [30.0])
        for _ in range(60):
            alone.step(500.0, 500.0, SURFACES["dry"], 0.005)
        assert (alone.speed[0], alone.wheel_speed[0]) == (together.speed[k], together.wheel_speed[k])
        assert alone.acceleration(SURFACES["dry"])[0] == together.acceleration(SURFACES["dry"])[k]


@pytest.mark.parametrize("name", ["radius", "inertia", "mass", "vertical_load"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_impossible_parameters_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} must be finite and > 0"):
        replace(CORNER, **{name: value})


def test_impossible_states_are_refused() -> None:
    with pytest.raises(ValueError, match="finite and >= 0"):
        SingleCorner(CORNER, [np.nan])
    with pytest.raises(ValueError, match="max_step"):
        SingleCorner(CORNER, [1.0], max_step=0.0)
