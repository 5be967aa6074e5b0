"""Tests of speed, yaw rate and ground speeds of the wheels, by drives whose truth is known."""

from collections import deque
from collections.abc import Sequence

import numpy as np
import pytest

from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.car_motion import CarMotion

CAR = load_vehicle("compact_car")
STEP = 5_000_000
DT = 0.005
NOISE = 0.07
"""Of a wheel speed [rad/s]."""


def rolling(vehicle: Vehicle, speed: float, yaw_rate: float) -> np.ndarray:
    """Return the rim speeds of wheels that roll in a curve [m/s]."""
    found = []
    for wheel in vehicle.wheels:
        left = 0.5 * vehicle.track * (1.0 if wheel.side == "left" else -1.0)
        ahead = vehicle.wheelbase if wheel.axle == "front" else 0.0
        found.append(np.hypot(speed - left * yaw_rate, ahead * yaw_rate))
    return np.array(found)


def followed(
    speeds: np.ndarray,
    yaw_rate: float = 0.0,
    slope: float = 0.0,
    slips: np.ndarray | None = None,
    yaw_known: bool = False,
    lost: Sequence[int] = (),
) -> tuple[CarMotion, np.ndarray]:
    """Drive without a brake pressure; return the filter and (error, deviation) of the speed at every sample."""
    rng = np.random.default_rng(11)
    motion = CarMotion(CAR, NOISE)
    accelerations = np.gradient(speeds, DT)
    found = []
    for k, (speed, acceleration) in enumerate(zip(speeds, accelerations, strict=True)):
        slip = 0.0 if slips is None else float(slips[k])
        rims = (1.0 - slip) * rolling(CAR, speed, yaw_rate) + 0.3 * NOISE * rng.normal(size=4)
        rims[list(lost)] = np.nan
        reading = acceleration + slope + 0.1 * rng.normal()
        motion.update((k + 1) * STEP, rims.tolist(), reading, yaw_rate=yaw_rate if yaw_known else None)
        if motion.started:
            found.append((motion.speed - speed, motion.variance**0.5))
    return motion, np.array(found)


def test_a_speed_is_there_as_soon_as_wheels_and_accelerometer_are() -> None:
    _, found = followed(np.full(400, 20.0))
    assert len(found) > 380
    assert np.all(np.abs(found[:, 0]) < 3.0 * found[:, 1])


@pytest.mark.parametrize("yaw_known", [True, False])
def test_a_curve_is_no_slip_with_a_yaw_rate_and_without(yaw_known: bool) -> None:
    yaw_rate = 0.25
    motion, found = followed(np.full(2000, 15.0), yaw_rate, yaw_known=yaw_known)
    assert np.all(np.abs(found[200:, 0]) < 0.1)
    assert motion.mean[3] == pytest.approx(yaw_rate, abs=0.02 if yaw_known else 2.0 * motion.covariance[3, 3] ** 0.5)
    for wheel, truth in enumerate(rolling(CAR, 15.0, yaw_rate)):
        ground, variance = motion.wheel(wheel)[:2]
        assert ground == pytest.approx(truth, abs=0.1 if yaw_known else 0.15)
        assert abs(ground - truth) < 3.0 * variance**0.5


def test_a_long_curve_without_a_yaw_rate_is_within_what_is_stated() -> None:
    motion, _ = followed(np.full(2000, 15.0), 0.25)
    assert abs(motion.mean[3] - 0.25) < 3.0 * motion.covariance[3, 3] ** 0.5
    for wheel, truth in enumerate(rolling(CAR, 15.0, 0.25)):
        ground, variance = motion.wheel(wheel)[:2]
        assert abs(ground - truth) < 3.0 * variance**0.5


def test_a_slope_is_learned_while_the_car_coasts() -> None:
    motion, found = followed(np.full(3000, 20.0), slope=0.5)
    assert motion.mean[1] == pytest.approx(0.5, abs=0.1)
    assert np.all(np.abs(found[400:, 0]) < 0.1)


def test_a_stop_with_slips_that_never_return_to_zero_is_covered() -> None:
    times = np.arange(0.0, 5.5, DT)
    speeds = 30.0 - 8.0 * np.maximum(times - 3.0, 0.0)
    slips = np.where(times < 3.0, 0.0, np.minimum((times - 3.0) / 0.3, 1.0) * (0.11 + 0.09 * np.sin(20.0 * times)))
    _, found = followed(speeds, slips=slips)
    braked = found[-480:]
    assert np.sqrt(np.mean(braked[:, 0] ** 2)) < 0.5  # the fastest wheel is wrong by 2.0 m/s
    assert np.mean(np.abs(braked[:, 0]) < 1.96 * braked[:, 1]) > 0.95


@pytest.mark.parametrize("lost", [(0,), (0, 1, 2)])
def test_wheels_that_are_missing_leave_the_speed_to_the_others(lost: tuple[int, ...]) -> None:
    _, found = followed(np.full(1000, 20.0), lost=lost)
    assert np.all(np.abs(found[200:, 0]) < 0.15)


def test_a_speed_sensor_counts_at_its_own_time() -> None:
    motion, _ = followed(np.full(600, 20.0))
    before = motion.variance
    motion.take_speed(590 * STEP, 20.0, 0.01**2)
    assert motion.speed == pytest.approx(20.0, abs=0.03)
    assert motion.variance <= before


def test_it_starts_again_after_a_second_of_silence() -> None:
    motion, _ = followed(np.full(600, 20.0))
    motion.update(600 * STEP + 1_100_000_000, [20.0] * 4, 0.0)
    assert not motion.started


def test_the_hypotheses_are_probabilities() -> None:
    motion, _ = followed(np.full(600, 20.0))
    assert motion.probabilities.sum() == pytest.approx(1.0)
    assert np.all(motion.probabilities >= 0.0)


@pytest.mark.parametrize("depth", [0.3, 0.5, 0.8])
def test_four_wheels_that_slide_for_long_do_not_outvote_the_accelerometer(depth: float) -> None:
    """Of tyres that keep a third of their friction; each goes to and fro beyond its peak, none comes back."""
    rng = np.random.default_rng(7)
    motion, radii = CarMotion(CAR, NOISE), np.array(CAR.radii)
    load = np.array([CAR.corner(wheel.name).vertical_load for wheel in CAR.wheels])
    inertia = np.array([wheel.inertia for wheel in CAR.wheels])
    behind = deque([[0.0] * 4] * 4, maxlen=4)
    speed, rims, off = 25.0, np.full(4, 25.0), []
    for k in range(1400):
        time = k * DT
        used, slides = float(np.clip(2.0 * (time - 1.0), 0.0, 1.0)), float(np.clip(2.5 * (time - 1.5), 0.0, 1.0))
        to_and_fro = 0.15 * np.sin(2.0 * np.pi * (3.0 * time + 0.3 * np.arange(4)))
        slip = 0.03 * used / (1.3 - used) + slides * (depth - 0.1 + to_and_fro)
        force = 0.2 * (used - 0.7 * slides) * load
        acceleration = -float(force.sum()) / CAR.mass
        speed += acceleration * DT
        before, rims = rims, (1.0 - slip) * speed
        torque = force * radii - inertia * (rims - before) / DT / radii
        reading = acceleration + 0.15 + 0.1 * rng.normal()
        measured = rims + NOISE * radii * rng.normal(size=4)
        motion.update((k + 1) * STEP, measured.tolist(), reading, torques=behind[0])
        behind.append(torque.tolist())
        if motion.started:
            off.append((motion.speed - speed) / motion.variance**0.5)
    assert np.abs(off).max() < 3.0
