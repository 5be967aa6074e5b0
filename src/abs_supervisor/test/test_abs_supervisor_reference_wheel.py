"""A rear wheel that rolls for a moment: when, which one, and for how long at most."""

from collections.abc import Callable
from math import nan

import numpy as np

from abs_supervisor.reference_wheel import ReferenceWheel

REAR = ("rear_left", "rear_right")
WHEELS = ("front_left", "front_right", *REAR)
STEP = 5_000_000
DT = 0.005
SNOW, DRY = 1.9, 9.0
"""Decelerations [m/s^2]."""
Stop = list[tuple[float, str]]


def stop(
    deceleration: float = SNOW,
    held: float = 0.06,
    torque: float = 200.0,
    opens: bool = True,
    wrong: Callable[[float], float] = lambda _time: 0.0,
    since: float = 0.0,
) -> Stop:
    """Brake from 30 m/s to rest; return when which wheel rolls. `wrong`: error of the speed, until a wheel shows it."""
    reference, rolling_for, error, found = ReferenceWheel(REAR), 0, 0.0, []
    for k in range(round(30.0 / deceleration / DT)):
        time = k * DT
        truth = 30.0 - deceleration * time
        if rolling_for * DT > 0.15:
            error = wrong(time)
        speed = truth + wrong(time) - error
        if not speed > 0.0:
            break
        rolls = {}
        for wheel in WHEELS:
            now = 0.0 if opens and rolling_for > 8 else torque
            rolls[wheel] = reference.rolls(
                wheel, (k + 1) * STEP, speed, deceleration, now, held if time >= since else nan
            )
        names = [wheel for wheel, is_so in rolls.items() if is_so]
        assert len(names) <= 1
        rolling_for = rolling_for + 1 if names else 0
        found += [(time, name) for name in names]
    return found


def beginnings(found: Stop) -> list[tuple[float, str]]:
    times = [-1.0, *(time for time, _ in found)]
    return [each for each, before in zip(found, times, strict=False) if each[0] - before > 1.5 * DT]


def test_on_snow_one_rear_wheel_after_the_other_rolls_now_and_then() -> None:
    found = beginnings(stop())
    assert [name for _, name in found] == ["rear_left", "rear_right", "rear_left"]
    assert found[0][0] > 2.0
    assert found[1][0] - found[0][0] > 3.5, "once the speed was right it is asked less often"
    assert 30.0 - SNOW * found[-1][0] > 7.0


def test_where_the_car_stands_before_its_speed_is_wrong_by_the_slip_that_is_held_none_rolls() -> None:
    assert not stop(DRY, held=0.17)
    assert not stop(7.5, held=0.13)
    assert stop(SNOW, held=0.3)


def test_a_speed_that_was_wrong_is_asked_again_soon_and_down_to_a_lower_speed() -> None:
    found = beginnings(stop(wrong=lambda t: -0.6 * t))
    gaps = np.diff([time for time, _ in found])
    assert gaps.min() < 1.7
    assert len(found) > 4
    assert 30.0 - SNOW * found[-1][0] < 7.0


def test_no_wheel_rolls_that_is_not_kept_below_the_demand_or_whose_speed_is_measured() -> None:
    assert not stop(held=nan)
    reference = ReferenceWheel(REAR)
    assert not any(reference.rolls("rear_left", k * STEP, nan, SNOW, 200.0, 0.06) for k in range(1, 2000))


def test_no_wheel_rolls_for_longer_than_a_third_of_a_second_whatever_is_measured() -> None:
    for found in (stop(opens=False), stop(torque=nan, opens=False)):
        lengths = [time for time, _ in found]
        starts = [time for time, _ in beginnings(found)]
        assert starts
        for start in starts:
            assert sum(start <= time < start + 1.0 for time in lengths) * DT <= 0.36


def test_a_wheel_that_is_not_heard_any_more_does_not_keep_the_turn() -> None:
    reference = ReferenceWheel(REAR)
    began = next(k for k in range(1, 4000) if reference.rolls("rear_left", k * STEP, 25.0, SNOW, 200.0, 0.06))
    after = range(began + 1, began + 2000)
    assert any(reference.rolls("rear_right", k * STEP, 25.0, SNOW, 200.0, 0.06) for k in after)


def test_each_braking_begins_anew() -> None:
    reference = ReferenceWheel(REAR)
    asked = [reference.rolls("rear_left", k * STEP, 25.0, SNOW, 200.0, 0.06) for k in range(1, 400)]
    later = [reference.rolls("rear_left", (k + 1000) * STEP, 25.0, SNOW, 200.0, 0.06) for k in range(1, 400)]
    assert not any(asked)
    assert not any(later)
