"""An accelerometer that follows the wheels late is found, named and left out; one that is in time never is."""

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.accelerometer_age import AccelerometerAge
from wheel_slip.estimator import SlipEstimator
from wheel_slip.tuning import SlideTuning

STEP = 10_000_000
CAR = load_vehicle("chapter_car")
RNG = np.random.default_rng(3)


def accelerations(seconds: float) -> np.ndarray:
    """Return those of a drive in town: faster, steady, slower, steady, for 2 to 4 s each [m/s^2], at 100 Hz."""
    parts = [
        np.full(int(RNG.integers(200, 400)), 1.4 * [1.0, 0.0, -1.0, 0.0][number % 4])
        for number in range(round(seconds / 2.0))
    ]
    return np.concatenate(parts)[: round(seconds / 0.01)]


def found(readings: np.ndarray, speeds: np.ndarray) -> list[float]:
    """Return the ages found at each sample [s]."""
    watch, ages = AccelerometerAge(SlideTuning()), []
    for number, (reading, speed) in enumerate(zip(readings, speeds, strict=True)):
        rims = speed + 0.02 * RNG.normal(size=4)
        watch.update((number + 1) * STEP, rims.tolist(), float(reading))
        ages.append(watch.late)
    return ages


def late(a: np.ndarray, seconds: float) -> np.ndarray:
    """Return the readings of an accelerometer that many seconds late, with noise and an offset [m/s^2]."""
    steps = round(seconds / 0.01)
    return np.concatenate([np.full(steps, a[0]), a[: len(a) - steps]]) + 0.3 + 0.1 * RNG.normal(size=len(a))


@pytest.mark.parametrize("age", [0.6, 1.0, 1.2])
def test_its_age_is_found_within_40_seconds(age: float) -> None:
    a = accelerations(40.0)
    ages = found(late(a, age), 15.0 + np.cumsum(a) * 0.01)
    assert ages[-1] == pytest.approx(age, abs=0.25)


@pytest.mark.parametrize("age", [0.0, 0.05, 0.15])
def test_one_that_is_in_time_or_nearly_so_is_left_alone_on_hills_too(age: float) -> None:
    a = accelerations(120.0)
    hills = 0.6 * np.sign(np.sin(0.13 * np.arange(a.size) * 0.01))
    assert not any(found(late(a, age) + hills, 15.0 + np.cumsum(a) * 0.01))


def test_noise_at_a_steady_speed_has_no_age() -> None:
    readings = RNG.normal(size=12_000)
    assert not any(found(readings, np.full(12_000, 20.0)))


def test_slip_that_builds_up_in_one_braking_is_no_lateness() -> None:
    times = np.arange(0.0, 14.0, 0.01)
    a = np.where(times < 4.0, 0.0, -1.5)
    speed = 30.0 + np.cumsum(a) * 0.01
    slip = 0.12 * np.clip((times - 4.0) / 1.5, 0.0, 1.0)
    assert not any(found(late(a, 0.0), speed * (1.0 - slip)))


def test_wheels_that_lock_and_turn_again_in_turns_are_no_lateness() -> None:
    times = np.arange(0.0, 40.0, 0.01)
    a = np.where(np.sin(0.4 * times) > 0.3, -2.0, 0.4)
    speed = 30.0 + np.cumsum(a) * 0.01
    slip = np.where(a < 0.0, 0.1 + 0.09 * np.sin(9.0 * times), 0.0)
    assert not any(found(late(a, 0.0), speed * (1.0 - slip)))


def test_over_a_gap_nothing_is_compared() -> None:
    watch = AccelerometerAge(SlideTuning())
    for number in range(400):
        watch.update((number + 1) * 300_000_000, [10.0 + number % 7] * 4, float(number % 5))
    assert watch.late == 0.0


def test_the_estimate_names_it_and_its_speed_is_covered_from_then_on() -> None:
    a = accelerations(90.0)
    speeds = 15.0 + np.cumsum(a) * 0.01
    estimator = SlipEstimator(CAR)
    errors = []
    for number, (reading, speed) in enumerate(zip(late(a, 1.0), speeds, strict=True)):
        rims = speed + 0.02 * RNG.normal(size=4)
        estimates = estimator.update((number + 1) * STEP, (rims / CAR.radii[0]).tolist(), float(reading))
        if estimator.vehicle.accelerometer_text and estimates[0].reason.value == 0:
            stddev = estimator.vehicle.stated_variance**0.5
            errors.append((estimates[0].vehicle_speed - speed) / stddev)
    assert "1.0 s late" in estimator.vehicle.accelerometer_text
    assert np.sqrt(np.mean(np.square(errors))) < 1.5
