"""Age of one signal against another: found by changes of the acceleration, never by slopes or slip."""

import numpy as np
import pytest

from sensor_monitor.signal_age import SignalAge

STEP = 5_000_000
DEVIATION = 0.07


def compared(age: float, accelerations: list[float], slope: list[float] | None = None) -> SignalAge:
    """Compare 1 s of each of some accelerations with a speed sensor of an age; `slope`: what the road adds."""
    watch, rng = SignalAge(DEVIATION, accelerometer=False), np.random.default_rng(3)
    rates = np.concatenate([np.zeros(400), np.repeat(accelerations, 200)])
    way = (
        np.cumsum(rates + np.concatenate([np.zeros(400), np.repeat(slope or [0.0] * len(accelerations), 200)])) * 0.005
    )
    speeds = 30.0 + np.cumsum(rates) * 0.005
    for k, travelled in enumerate(way):
        watch.follow(k * STEP, float(travelled))
        if k % 10 == 0:
            told = speeds[max(k - round(age / 0.005), 0)]
            watch.compare(k * STEP, float(told + 0.1 * rng.normal()), float(rates[k]), 0.01)
    return watch


def test_a_car_that_keeps_its_acceleration_says_nothing_of_the_age() -> None:
    watch = compared(0.3, [0.0] * 6)
    assert watch.text == ""
    assert watch.age_variance == pytest.approx(SignalAge(DEVIATION, accelerometer=False).age_variance, rel=0.3)


@pytest.mark.parametrize("strong", [-4.0, -8.0, 3.0])
def test_one_change_of_acceleration_shows_the_age(strong: float) -> None:
    assert compared(0.0, [0.0, 0.0, strong, strong]).age_variance < 0.04**2
    late = compared(0.45, [0.0, 0.0, strong, strong])
    assert float(late.text.split()[1]) == pytest.approx(0.45, abs=0.1)


@pytest.mark.parametrize("step", [-1.0, 1.0])
def test_a_step_of_slope_in_a_braking_does_not_pass_for_an_age(step: float) -> None:
    watch = compared(0.0, [0.0, 0.0, -6.0, -6.0, -6.0, -6.0], [0.0, 0.0, 0.0, step, step, step])
    assert watch.text == ""


def test_a_turned_and_a_stuck_accelerometer_are_told_and_a_healthy_one_is_not() -> None:
    for factor, said in ((1.0, ""), (-1.0, "wrong sign"), (0.0, "nothing")):
        watch, rng = SignalAge(DEVIATION, accelerometer=True), np.random.default_rng(3)
        rates = np.repeat(rng.uniform(-3.0, 2.0, size=20), 200)
        speeds, way = 30.0 + np.cumsum(rates) * 0.005, np.cumsum(factor * rates + 0.1) * 0.005
        for k in range(rates.size):
            watch.follow(k * STEP, float(speeds[k] + 0.05 * rng.normal()))
            watch.compare(k * STEP, float(way[k]), factor * float(rates[k]), 0.01)
        assert said in watch.text and bool(watch.text) == bool(said)


def test_signals_with_gaps_are_not_compared_across_them() -> None:
    watch = SignalAge(DEVIATION, accelerometer=True)
    for k in range(400):
        watch.follow(k * 700_000_000, 10.0 + k % 7)
        watch.compare(k * 700_000_000, float(k % 5), 0.0, 0.01)
    assert watch.text == ""
