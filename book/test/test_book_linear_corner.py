"""(8.1) and (8.2) against the plant that they linearise: derivatives, step and frequency response, stability."""

from dataclasses import replace

import numpy as np
import pytest

from book.linear_corner import deceleration_transfer, is_stable, pole, slip_transfer
from corner_sim.corner import SingleCorner
from vehicle_models import burckhardt
from vehicle_models.surfaces import SURFACES, TABLE_8_1
from vehicle_models.vehicle import CornerParameters
from vehicle_models.vehicle_file import load_vehicle

CORNER = load_vehicle("chapter_corner").corner("front_left")
HEAVY = replace(CORNER, mass=400.0, vertical_load=400.0 * 9.81, radius=0.33, inertia=1.6)
LOADED = replace(CORNER, vertical_load=1.4 * CORNER.vertical_load)
CORNERS = pytest.mark.parametrize("corner", [CORNER, HEAVY, LOADED], ids=["chapter", "heavy", "loaded"])
SIDES = pytest.mark.parametrize("of_peak", [0.3, 0.7, 1.4, 2.2])
SPEEDS = pytest.mark.parametrize("speed", [5.0, 15.0, 30.0])


def slip_at(name: str, of_peak: float) -> float:
    return of_peak * float(burckhardt.peak(SURFACES[name])[0])


def torque_that_holds(corner: CornerParameters, theta: np.ndarray, slip: float) -> float:
    """Brake torque at which the slip stays, from (2.15): omega_dot = (1 - slip) v_dot / r."""
    force = corner.vertical_load * float(burckhardt.friction(theta, slip))
    return force * (corner.radius + corner.inertia * (1.0 - slip) / (corner.mass * corner.radius))


def plant_at(corner: CornerParameters, slip: float, speed: float) -> SingleCorner:
    return SingleCorner(corner, [speed], [(1.0 - slip) * speed / corner.radius])


def rates(corner: CornerParameters, theta: np.ndarray, slip: float, speed: float, torque: float) -> tuple[float, float]:
    """Slip rate and eta of the plant."""
    plant = plant_at(corner, slip, speed)
    wheel = float(plant.wheel_acceleration(theta, torque)[0])
    slip_rate = ((1.0 - slip) * float(plant.acceleration(theta)[0]) - corner.radius * wheel) / speed
    return slip_rate, -corner.radius * wheel / corner.gravity


@CORNERS
@SIDES
@SPEEDS
@pytest.mark.parametrize("name", TABLE_8_1)
def test_both_transfer_functions_are_those_of_the_linearised_plant(
    name: str, speed: float, of_peak: float, corner: CornerParameters
) -> None:
    theta, slip = SURFACES[name], slip_at(name, of_peak)
    torque, step = torque_that_holds(corner, theta, slip), 1e-5
    above, below = (rates(corner, theta, slip + sign * step, speed, torque) for sign in (1.0, -1.0))
    a, c = ((high - low) / (2.0 * step) for high, low in zip(above, below, strict=True))
    above, below = (rates(corner, theta, slip, speed, torque + sign) for sign in (1.0, -1.0))
    b, d = (0.5 * (high - low) for high, low in zip(above, below, strict=True))
    # what the change of speed adds is not in (8.1)
    a -= corner.gravity * float(burckhardt.friction(theta, slip)) / speed
    assert a == pytest.approx(pole(corner, theta, slip, speed), rel=1e-5)
    numerator, denominator = slip_transfer(corner, theta, slip, speed)
    assert numerator == pytest.approx([b], rel=1e-6)
    assert denominator == pytest.approx([1.0, -a], rel=1e-5)
    numerator, denominator = deceleration_transfer(corner, theta, slip, speed)
    assert numerator == pytest.approx([d, c * b - d * a], rel=1e-5)  # c (s - a)^-1 b + d
    assert denominator == pytest.approx([1.0, -a], rel=1e-5)


@CORNERS
@SIDES
@SPEEDS
def test_the_slip_of_the_plant_answers_to_a_step_of_torque_as_8_1_says(
    speed: float, of_peak: float, corner: CornerParameters
) -> None:
    theta, slip, extra = SURFACES["dry"], slip_at("dry", of_peak), 0.2
    dt = 0.01 / 40.0 * speed / 9.81  # the speed changes by 1 % in 40 steps
    torque = torque_that_holds(corner, theta, slip)
    held, stepped = plant_at(corner, slip, speed), plant_at(corner, slip, speed)
    (gain,), (_, decay) = slip_transfer(corner, theta, slip, speed)
    for k in range(1, 41):
        held.step(torque, torque, theta, dt)
        stepped.step(torque + extra, torque + extra, theta, dt)
        expected = extra * gain * -np.expm1(-decay * k * dt) / decay
        assert stepped.slip[0] - held.slip[0] == pytest.approx(expected, rel=0.02)


@CORNERS
@pytest.mark.parametrize("frequency", [8.0, 40.0])
def test_the_deceleration_of_the_plant_answers_to_a_sine_of_torque_as_8_2_says(
    frequency: float, corner: CornerParameters
) -> None:
    theta, speed, slip, extra = SURFACES["wet"], 60.0, slip_at("wet", 0.3), 0.5
    torque, omega = torque_that_holds(corner, theta, slip), 2.0 * np.pi * frequency
    held, driven = plant_at(corner, slip, speed), plant_at(corner, slip, speed)
    numerator, denominator = deceleration_transfer(corner, theta, slip, speed)
    response = np.polyval(numerator, 1j * omega) / np.polyval(denominator, 1j * omega)
    settled, period = 4.0 / denominator[1], 1.0 / frequency
    dt = period / 80.0
    found = 0.0j
    times = dt * np.arange(round(settled / dt) + 80)
    for k, time in enumerate(times):
        now, then = extra * np.sin(omega * np.array([time, time + dt]))
        if k >= len(times) - 80:
            difference = driven.wheel_acceleration(theta, torque + now) - held.wheel_acceleration(theta, torque)
            found += 2.0 / 80.0 * -corner.radius / corner.gravity * difference[0] * np.exp(-1j * omega * time) * 1j
        held.step(torque, torque, theta, dt)
        driven.step(torque + now, torque + then, theta, dt)
    assert abs(found / extra - response) < 0.04 * abs(response)


@CORNERS
@pytest.mark.parametrize("name", TABLE_8_1)
def test_the_plant_returns_to_its_slip_before_the_peak_and_leaves_it_beyond(
    name: str, corner: CornerParameters
) -> None:
    theta, dt = SURFACES[name], 5e-4
    for of_peak in (0.3, 0.8, 1.3, 2.2):
        slip = slip_at(name, of_peak)
        torque = torque_that_holds(corner, theta, slip)
        held, pushed = plant_at(corner, slip, 20.0), plant_at(corner, slip + 1e-5, 20.0)
        for _ in range(100):
            held.step(torque, torque, theta, dt)
            pushed.step(torque, torque, theta, dt)
        returns = bool(abs(pushed.slip[0] - held.slip[0]) < 1e-5)
        assert returns == bool(is_stable(theta, slip)) == (of_peak < 1.0), of_peak


def test_speed_scales_the_pole_and_does_not_change_its_sign() -> None:
    for name in TABLE_8_1:
        for of_peak in (0.5, 2.0):
            theta, slip = SURFACES[name], slip_at(name, of_peak)
            poles = [speed * pole(CORNER, theta, slip, speed) for speed in (1.0, 7.0, 30.0)]
            assert poles == pytest.approx([poles[0]] * 3, rel=1e-12)
            assert (poles[0] < 0.0) == bool(is_stable(theta, slip))
    assert is_stable(SURFACES["dry"], [0.0, 0.1, 0.2, 1.0]).tolist() == [True, True, False, False]


def test_a_standing_car_has_no_linear_corner() -> None:
    with pytest.raises(ValueError, match="speed must be > 0"):
        slip_transfer(CORNER, SURFACES["dry"], 0.1, 0.0)
