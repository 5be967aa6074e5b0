"""An accelerometer that is late, turned or stuck is named, and wheels give the speed; one that is right never is."""

import numpy as np
import pytest

from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator

CAR = load_vehicle("compact_car")
STEP = 0.01


def accelerations(seconds: float) -> np.ndarray:
    """Return those of a drive in traffic, another one every two seconds [m/s^2]."""
    rng = np.random.default_rng(7)
    levels = np.repeat(rng.uniform(-2.5, 1.5, size=round(seconds / 2.0)), 200)
    smooth = np.convolve(levels, np.ones(30) / 30.0, mode="same")
    return smooth - smooth.mean()


def drive(read: np.ndarray, a: np.ndarray) -> tuple[str, np.ndarray]:
    """Drive with an accelerometer that reads so; return what is said of it and the z of all valid speeds."""
    rng = np.random.default_rng(3)
    estimator = SlipEstimator(CAR)
    speeds = 20.0 + np.cumsum(a) * STEP
    named, z = "", []
    for k, (reading, speed, true) in enumerate(zip(read, speeds, a, strict=True), start=1):
        slips = np.array([0.006 * -true if true < 0.0 or wheel.driven else 0.0 for wheel in CAR.wheels])
        omega = speed * (1.0 - slips) / np.array(CAR.radii) + 0.07 * rng.normal(size=4)
        rows = estimator.update(round(k * STEP * 1e9), omega.tolist(), float(reading))
        named = named or estimator.accelerometer_text
        if rows[0].reason is Reason.OK:
            z.append((rows[0].vehicle_speed - speed) / rows[0].vehicle_speed_variance ** 0.5)
    return named, np.array(z)


def late(a: np.ndarray, seconds: float) -> np.ndarray:
    """Return readings that are so late [s], with noise."""
    steps = round(seconds / STEP)
    noise = 0.1 * np.random.default_rng(9).normal(size=a.size)
    return np.concatenate([np.full(steps, a[0]), a[: a.size - steps]]) + noise


@pytest.mark.parametrize("age", [0.6, 1.0, 1.5])
def test_a_late_one_is_named_and_its_speed_is_covered(age: float) -> None:
    a = accelerations(60.0)
    named, z = drive(late(a, age), a)
    assert "late" in named
    assert np.mean(np.abs(z) < 2.0) > 0.85


def test_a_turned_one_and_one_that_reads_noise_are_named() -> None:
    a = accelerations(60.0)
    noise = 0.1 * np.random.default_rng(9).normal(size=a.size)
    assert drive(noise - a, a)[0]
    assert drive(noise, a)[0]


@pytest.mark.parametrize("factor, held", [(1.0, True), (-1.0, False), (0.0, False)])
def test_one_that_fails_in_mid_drive_is_named_and_the_speed_stays_covered(factor: float, held: bool) -> None:
    a = accelerations(60.0)
    read, half = late(a, 0.0), a.size // 2
    read[half:] = read[half] if held else factor * read[half:]
    named, z = drive(read, a)
    assert named
    assert np.mean(np.abs(z[half:]) < 2.0) > 0.85


@pytest.mark.parametrize("age", [0.0, 0.01])
@pytest.mark.parametrize("bias", [-0.35, 0.0, 0.35])
def test_one_that_is_right_is_not_named_whatever_its_bias_and_scale(age: float, bias: float) -> None:
    a = accelerations(60.0)
    for scale in (0.95, 1.05):
        named, z = drive(scale * late(a, age) + bias, a)
        assert named == ""
        assert np.mean(np.abs(z) < 2.0) > 0.9


def test_noise_at_a_steady_speed_says_nothing() -> None:
    a = np.zeros(6000)
    assert drive(late(a, 0.0), a)[0] == ""


def test_without_one_wheels_and_a_speed_that_stays_are_known() -> None:
    a = accelerations(40.0)
    named, z = drive(np.full(a.size, np.nan), a)
    assert named == "" and z.size > 0.9 * a.size
    assert np.mean(np.abs(z) < 2.0) > 0.9
