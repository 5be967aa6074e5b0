"""A wheel speed that repeats itself is that of a dead sensor where the other wheels change theirs."""

from math import nan

import pytest

from sensor_monitor.frozen_wheel import FrozenWheels

STEP = 5_000_000


def frozen(deceleration: float, stuck: float | None, others: int = 3, seconds: float = 1.0) -> list[bool]:
    """Return by sample whether the first of some wheels is frozen; it keeps its speed from `stuck` [s] on."""
    wheels, found = FrozenWheels(), []
    for k in range(round(seconds / 0.005)):
        t = k * 0.005
        speeds = [20.0 - deceleration * (t if stuck is None or each else min(t, stuck)) for each in range(1 + others)]
        found.append(wheels.update((k + 1) * STEP, speeds)[0])
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


def test_one_wheel_alone_is_compared_with_nothing() -> None:
    assert not any(frozen(8.0, stuck=0.5, others=0))


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
