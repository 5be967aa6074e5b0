"""The noise of wheel speeds is that which they show, where it is far more than what is stated."""

from collections.abc import Callable

import numpy as np
import pytest

from sensor_monitor.wheel_noise import WheelNoise

STATED = 0.07**2


def drive(
    speeds: Callable[[float, np.random.Generator], np.ndarray], rate: float = 200.0, alike: bool = True
) -> WheelNoise:
    """Drive for 5 s; `speeds` gives the wheel speeds at a time [s]."""
    rng, noise = np.random.default_rng(3), WheelNoise(STATED)
    for number in range(round(5.0 * rate)):
        noise.update(round((number + 1) / rate * 1e9), speeds(number / rate, rng).tolist(), alike)
    return noise


def motion(time: float) -> np.ndarray:
    """Four wheels of a car that brakes on a bend: they lose 11 rad/s^2, and the outer ones less."""
    return 200.0 - 11.0 * time + np.sin(time) * np.array([1.0, -1.0, 1.0, -1.0])


@pytest.mark.parametrize("rate", [25.0, 100.0, 200.0])
@pytest.mark.parametrize("stddev", [0.3, 1.0])
def test_noise_beyond_what_is_stated_is_found_at_every_rate(rate: float, stddev: float) -> None:
    noise = drive(lambda time, rng: motion(time) + stddev * rng.normal(size=4), rate)
    assert noise.variance**0.5 == pytest.approx(stddev, rel=0.25)


def test_steps_of_a_coarse_counter_are_noise() -> None:
    noise = drive(lambda time, rng: np.round((motion(time) + np.array([0.3, 0.0, 0.7, 1.1])) / 1.5) * 1.5)
    assert 0.5 * 1.5 / 12**0.5 < noise.variance**0.5 < 2.0 * 1.5 / 12**0.5


@pytest.mark.parametrize("stddev", [0.07, 0.14])
def test_noise_about_as_stated_counts_as_stated_whatever_the_car_does(stddev: float) -> None:
    assert drive(lambda time, rng: motion(time) + stddev * rng.normal(size=4)).variance == STATED


def test_wheels_unlike_each_other_and_one_that_is_missing_say_nothing() -> None:
    assert drive(lambda time, rng: motion(time) + rng.normal(size=4), alike=False).variance == STATED
    missing = [0.0, 0.0, 0.0, np.nan]
    assert drive(lambda time, rng: motion(time) + rng.normal(size=4) + missing).variance == STATED


@pytest.mark.parametrize("turning", [30.0, 60.0, 100.0, 125.0])
@pytest.mark.parametrize("count", [1, 4])
def test_a_ring_that_is_not_round_makes_noise_that_lasts(turning: float, count: int) -> None:
    rng, noise = np.random.default_rng(3), WheelNoise(STATED)
    phases = np.array([0.0, 2.0, 3.0, 5.0])[:count]
    for number in range(1000):
        time = 0.005 * number
        felt = turning - 3.0 * np.sin(time)
        ripple = 0.02 * turning * np.sin(turning * time + phases)
        noise.update(number * 5_000_000, (felt + ripple + 0.07 * rng.normal(size=count)).tolist(), True, felt - turning)
    assert noise.lasting**0.5 == pytest.approx(0.02 * turning / 2**0.5, rel=0.3)


def test_white_noise_does_not_last() -> None:
    noise = drive(lambda time, rng: motion(time) + 0.5 * rng.normal(size=4))
    assert noise.lasting < 0.1 * noise.variance
