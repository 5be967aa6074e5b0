"""A wheel speed that repeats itself is that of a dead sensor where the other wheels change theirs."""

from math import nan

import pytest

from sensor_monitor.frozen_wheel import DEAD, STUCK, FrozenWheels

STEP = 5_000_000


def frozen(deceleration: float, stuck: float | None, others: int = 3, seconds: float = 1.0) -> list[bool]:
    """Return by sample whether the first of some wheels is frozen; it keeps its speed from `stuck` [s] on."""
    wheels, found = FrozenWheels(), []
    for k in range(round(seconds / 0.005)):
        t = k * 0.005
        speeds = [20.0 - deceleration * (t if stuck is None or each else min(t, stuck)) for each in range(1 + others)]
        found.append(wheels.update((k + 1) * STEP, speeds)[0] == STUCK)
    return found


def test_it_is_named_as_soon_as_the_others_have_lost_half_a_metre_per_second() -> None:
    found = frozen(8.0, stuck=0.5)
    assert not any(found[:100])
    assert all(found[100 + 15 :])


@pytest.mark.parametrize("stuck", [None, 0.0])
def test_wheels_that_all_keep_their_speed_roll(stuck: float | None) -> None:
    assert not any(frozen(0.0, stuck))


def test_a_wheel_that_changes_is_not_frozen() -> None:
    assert not any(frozen(8.0, None))


def test_one_wheel_alone_is_compared_with_what_the_car_feels() -> None:
    assert not any(frozen(8.0, stuck=0.5, others=0))
    wheels = FrozenWheels()
    found = [wheels.update(k * STEP, [20.0], felt=-0.04 * k)[0] for k in range(1, 100)]
    assert found[:10] == [""] * 10
    assert found[20:] == [STUCK] * 79


def test_wheels_that_are_missing_say_nothing() -> None:
    wheels = FrozenWheels()
    assert not any(wheels.update(k * STEP, [20.0, nan, nan])[0] for k in range(1, 100))


def test_standing_wheels_are_not_frozen() -> None:
    wheels = FrozenWheels()
    assert not any(wheels.update(k * STEP, [0.0, 20.0 - 0.1 * k, 20.0 - 0.1 * k])[0] for k in range(1, 100))


def test_after_a_reset_it_begins_anew() -> None:
    wheels = FrozenWheels()
    for k in range(1, 50):
        wheels.update(k * STEP, [20.0, 20.0 - 0.1 * k, 20.0 - 0.1 * k])
    wheels.reset()
    assert not any(wheels.update(50 * STEP, [20.0, 15.0, 15.0]))


def stopped(decelerations: list[float], step: int = STEP) -> list[str]:
    """Return what is said of a wheel at 25 m/s that loses so much from sample to sample [m/s]."""
    wheels, speed, found = FrozenWheels(), 25.0, []
    for k, loss in enumerate([0.0, *decelerations]):
        speed -= loss
        found.append(wheels.update((k + 1) * step, [speed, 25.0, 25.0])[0])
    return found


def test_a_wheel_that_stops_from_one_sample_to_the_next_is_dead_until_it_turns() -> None:
    assert stopped([25.0, 0.0, 0.0, -24.0, 1.0]) == ["", DEAD, DEAD, DEAD, "", ""]


@pytest.mark.parametrize(("losses", "step"), [([5.0] * 5, STEP), ([9.0] * 2 + [7.0], STEP), ([25.0], 20_000_000)])
def test_a_wheel_that_its_brake_can_stop_is_not_dead(losses: list[float], step: int) -> None:
    assert DEAD not in stopped([*losses, 0.0, 0.0], step)


def test_a_dead_wheel_whose_samples_are_missing_meanwhile_stays_dead() -> None:
    assert stopped([25.0, nan, nan])[1:] == [DEAD, DEAD, DEAD]
