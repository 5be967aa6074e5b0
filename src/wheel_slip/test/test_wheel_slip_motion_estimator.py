"""Slip by one filter of the car's motion: wheels that fail, lock, spin or come back, and a missing accelerometer."""

from math import isnan, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray

from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.motion_estimate import WheelEstimate
from wheel_slip.motion_estimator import MotionSlipEstimator
from wheel_slip.speed_sample import SpeedSample

STEP = 5_000_000
RADIUS = 0.3
CAR = load_vehicle("chapter_car")
Array = NDArray[np.float64]


def stop(deceleration: float, slip: Array, speed: float) -> tuple[Array, Array, Array]:
    """Roll for 3 s, then brake with a slip of all wheels: speed, wheel speeds and readings at 200 Hz."""
    rng = np.random.default_rng(5)
    t = 0.005 * np.arange(slip.size)
    a = -deceleration * np.clip((t - 3.0) / 0.2, 0.0, 1.0)
    true = speed + np.concatenate([[0.0], np.cumsum(0.0025 * (a[1:] + a[:-1]))])
    wheels = ((1.0 - slip) * true / RADIUS)[:, None] + 0.07 * rng.normal(size=(slip.size, 4))
    return true, wheels, a + 0.25 + 0.1 * rng.normal(size=slip.size)


def hard_stop() -> tuple[Array, Array, Array]:
    """8 m/s^2 with slips that swing between 2 and 20 %, never back to zero."""
    t = 0.005 * np.arange(1100)
    grown = np.clip((t - 3.0) / 0.3, 0.0, 1.0)
    return stop(8.0, grown * (0.11 + 0.09 * np.sin(20.0 * (t - 3.0))), 30.0)


def follow(wheels: Array, readings: Array | None) -> list[WheelEstimate]:
    """Return the answers for the first wheel."""
    estimator = MotionSlipEstimator(CAR)
    given = [None] * len(wheels) if readings is None else readings.tolist()
    return [
        estimator.update((k + 1) * STEP, omega, reading)[0]
        for k, (omega, reading) in enumerate(zip(wheels.tolist(), given, strict=True))
    ]


def off(found: list[WheelEstimate], true: Array) -> tuple[Array, Array]:
    """Errors of the speed [m/s], and these over what is stated."""
    errors = np.array([each.vehicle_speed for each in found]) - true
    return np.abs(errors), np.abs(errors) / np.sqrt([each.vehicle_speed_variance for each in found])


@pytest.mark.parametrize("reading", [0.0, 300.0], ids=["dead", "spinning"])
def test_a_wheel_that_has_failed_does_not_disturb_the_speed(reading: float) -> None:
    true, wheels, readings = hard_stop()
    wheels[:, 1] = reading
    assert np.max(off(follow(wheels, readings), true)[0][100:]) < 0.12


def test_without_an_accelerometer_swinging_wheels_are_within_what_is_stated() -> None:
    true, wheels, _ = hard_stop()
    errors, z = off(follow(wheels, None), true)
    assert np.max(errors[200:600]) < 0.1
    assert np.max(z[600:]) < 2.5


def test_a_car_with_locked_wheels_from_the_start_is_not_known_to_stand() -> None:
    found = follow(np.zeros((300, 4)), np.full(300, -7.0) + 0.1 * np.random.default_rng(5).normal(size=300))
    assert {each.reason for each in found} <= {Reason.UNCERTAIN, Reason.NO_SPEED, Reason.NOT_READY}
    assert min(sqrt(each.vehicle_speed_variance) for each in found[100:]) > 100.0


def test_a_start_from_rest_is_followed_though_encoders_read_nothing_below_half_a_metre_a_second() -> None:
    rng = np.random.default_rng(5)
    true = 2.0 * np.clip(0.005 * np.arange(1000) - 2.0, 0.0, None)
    noisy = true[:, None] / RADIUS + 0.07 * rng.normal(size=(1000, 4))
    wheels = np.where(true[:, None] < 0.5, 0.0, noisy)
    found = follow(wheels, np.where(true > 0.0, 2.0, 0.0) + 0.25 + 0.1 * rng.normal(size=1000))
    assert np.max(off(found, true)[0][100:]) < 0.15
    assert found[390].reason is Reason.LOW_SPEED
    assert isnan(found[390].slip)
    assert found[-1].reason is Reason.OK


def test_a_single_wheel_that_spins_up_moves_neither_speed_nor_what_is_thought_of_the_sensors() -> None:
    estimator, rng = MotionSlipEstimator(load_vehicle("chapter_corner")), np.random.default_rng(5)
    found: list[WheelEstimate] = []
    for k in range(1, 600):
        spun = 1.0 if k < 200 else 1.0 + min(0.02 * (k - 200), 4.0)
        known = [SpeedSample(k * STEP, 10.0 + 0.1 * rng.normal(), 0.01)]
        found += estimator.update(k * STEP, (10.0 * spun / RADIUS,), 0.1 * rng.normal(), known)
    assert found[-1].vehicle_speed == pytest.approx(10.0, abs=0.3)
    assert found[-1].reason is Reason.BAD_INPUT
    assert estimator.accelerometer.text == estimator.speed_sensor.text == ""


def test_a_wheel_that_is_released_on_snow_takes_back_what_an_unseen_slope_did_to_the_speed() -> None:
    """A hill of 6 % begins as all wheels slip by 10 %; then a rear wheel rolls for 0.1 s, its brake open."""
    car = load_vehicle("compact_car")
    rng, estimator = np.random.default_rng(5), MotionSlipEstimator(car)
    speed, errors = 25.0, []
    load = car.mass * 9.81 * np.array(car.load_shares)
    for k in range(1, 1400):
        t = 0.005 * k
        braked = t > 3.0
        held = float(np.interp(t, [6.0, 6.05, 6.2, 6.25], [1.0, 0.0, 0.0, 1.0]))
        felt = -1.9 * (1.0 - car.load_shares[2] * (1.0 - held)) if braked else 0.0
        speed += 0.005 * (felt + (0.6 if t > 3.5 else 0.0))
        slip = np.full(4, 0.1 if braked else 0.0)
        torques = np.where(braked, 0.19 * load * car.wheels[0].radius, 0.0) * np.ones(4)
        slip[2] *= held
        torques[2] *= held
        omega = speed * (1.0 - slip) / np.array(car.radii) + 0.07 * rng.normal(size=4)
        row = estimator.update(k * STEP, omega.tolist(), felt + 0.1 * rng.normal(), torques=torques.tolist())
        errors.append(abs(row[0].vehicle_speed - speed))
    assert errors[1195] > 0.8
    assert errors[1250] < 0.5 * errors[1195]
    assert estimator.hypotheses.slope_changed > 0.5
