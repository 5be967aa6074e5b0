"""Brake pressures that miss braking are named, and the speed stays covered; those that are right never are."""

from collections import deque

import numpy as np
import pytest

from corner_sim.corner import SingleCorner
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator

CAR = load_vehicle("compact_car")
STEP = 0.005
RADII = np.array(CAR.radii)
LOADS = 9.81 * CAR.mass * np.array(CAR.load_shares)
LATE = round(0.02 / STEP)


def brakings(hardest: float, engine: float) -> np.ndarray:
    """Return decelerations [m/s^2]: the engine drives, the pedals change, and brakes act for 2 s; three times."""
    once = np.interp(np.arange(0.0, 6.0, STEP), [0.0, 2.5, 2.8, 3.0, 3.15, 5.0, 5.2], [engine, engine, 0, 0, 1, 1, 0])
    return np.tile(np.where(once > 0.0, once * hardest, once), 3)


def drive(a: np.ndarray, read: np.ndarray) -> tuple[str, str, np.ndarray]:
    """Brake a car with these shares of the torques read; return what is said of pressures and accelerometer, and z."""
    rng, estimator = np.random.default_rng(5), SlipEstimator(CAR)
    speeds = 45.0 - np.cumsum(a) * STEP
    torques = np.maximum(a, 0.0)[:, None] / 9.81 * LOADS * RADII
    pressures, accelerometer, z = "", "", []
    for k in range(a.size):
        slip = 0.007 * a[k] if a[k] > 0.0 else 0.0
        omega = speeds[k] * (1.0 - slip) / RADII + 0.05 * rng.normal(size=4)
        told = (read * torques[max(k - LATE, 0)]).tolist()
        reading = -a[k] + 0.1 * rng.normal()
        rows = estimator.update(round((k + 1) * STEP * 1e9), omega.tolist(), reading, torques=told)
        pressures, accelerometer = pressures or estimator.pressure_text, accelerometer or estimator.accelerometer_text
        if rows[0].reason is Reason.OK:
            z.append((rows[0].vehicle_speed - speeds[k]) / rows[0].vehicle_speed_variance ** 0.5)
    return pressures, accelerometer, np.array(z)


@pytest.mark.parametrize("wheel", [0, 1])
def test_a_pressure_that_reads_nothing_in_a_hard_stop_is_named_and_the_speed_is_covered(wheel: int) -> None:
    read = np.ones(4)
    read[wheel] = 0.0
    pressures, _, z = drive(brakings(7.0, -0.5), read)
    assert "reads too little" in pressures
    assert np.mean(np.abs(z) < 2.0) > 0.95


@pytest.mark.parametrize("gain", [0.9, 1.0, 1.1])
@pytest.mark.parametrize("engine", [-3.0, 0.0])
def test_pressures_that_are_right_are_not_named_whatever_pads_and_pedals_do(gain: float, engine: float) -> None:
    for hardest in (2.0, 8.0):
        pressures, _, z = drive(brakings(hardest, engine), np.full(4, gain))
        assert pressures == ""
        assert np.mean(np.abs(z) < 2.0) > 0.9


@pytest.mark.parametrize("road", ["wet", "snow"])
def test_a_brake_that_is_modulated_from_step_to_step_leaves_the_slip_covered(road: str) -> None:
    """A torque that alternates every 20 ms by 15 %, as that of an ABS which holds the slip near 0.09."""
    vehicle, theta, random = load_vehicle("chapter_corner"), surface(road), np.random.default_rng(0)
    wheel = vehicle.corner("front_left")
    corner, estimator, hold = SingleCorner(wheel, [30.0]), SlipEstimator(vehicle), float(wheel.peak_torque(theta))
    torque, level, late, missed = 0.0, 0.0, deque([0.0] * (LATE + 1), maxlen=LATE + 1), []
    for k in range(1400):
        braked, slip, speed = k >= 600, float(corner.slip[0]), float(corner.speed[0])
        level = min(max(level + (10.0 if slip < 0.09 else -10.0), 0.0), 1.3 * hold) if braked else 0.0
        following = level * (1.15 if k // 4 % 2 else 0.85)
        late.append(torque)
        reading = float(corner.acceleration(theta)[0]) + 0.05 * random.normal()
        omega = float(corner.wheel_speed[0]) + 0.05 * random.normal()
        (found,) = estimator.update(round((k + 1) * STEP * 1e9), [omega], reading, torques=[late[0]])
        if k > 640 and speed > 5.0 and found.reason is Reason.OK:
            missed.append(abs(found.slip - slip) > 1.96 * found.slip_variance**0.5)
        corner.step(torque, following, theta, STEP)
        torque = following
    assert len(missed) > 400
    assert np.mean(missed) < 0.02
