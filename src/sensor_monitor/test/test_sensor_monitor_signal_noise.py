"""White noise of a signal is found on a signal that moves, and a jump is not noise."""

import numpy as np
import pytest

from sensor_monitor.signal_noise import SignalNoise, white_noise

STEP = 5_000_000


@pytest.mark.parametrize("stddev", [0.02, 0.5, 3.0])
def test_noise_is_found_on_a_signal_that_swings(stddev: float) -> None:
    rng, noise = np.random.default_rng(2), SignalNoise(0.01, 1e-6)
    for k in range(2000):
        noise.update(k * STEP, 5.0 * np.sin(0.03 * k) + stddev * rng.normal())
    assert noise.variance**0.5 == pytest.approx(stddev, rel=0.3)
    assert noise.drift == pytest.approx(noise.variance * 0.005)


def test_a_jump_and_a_gap_are_no_noise() -> None:
    rng, noise = np.random.default_rng(2), SignalNoise(0.01, 1e-6)
    for k in range(2000):
        noise.update((k if k < 1500 else k + 100) * STEP, (100.0 if k > 1000 else 0.0) + 0.1 * rng.normal())
    assert noise.variance**0.5 == pytest.approx(0.1, rel=0.3)


def test_none_is_below_the_least() -> None:
    noise = SignalNoise(0.01, 1e-4)
    for k in range(1000):
        noise.update(k * STEP, 1.0)
    assert noise.variance == pytest.approx(1e-4)


@pytest.mark.parametrize("stddev", [0.02, 0.5])
def test_noise_of_samples_is_found_beside_a_jump(stddev: float) -> None:
    rng, time = np.random.default_rng(2), 0.005 * np.arange(80)
    signals = 5.0 * np.sin(3.0 * time) + stddev * rng.normal(size=(4, 80))
    signals[0, 60:] += 10.0
    assert white_noise(signals) == pytest.approx(np.full(4, stddev), rel=0.4)
