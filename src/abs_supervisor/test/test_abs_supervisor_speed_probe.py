"""A rear wheel that is braked less for a moment: when, which one, and for how long at most."""

from math import nan

from abs_supervisor.speed_probe import SpeedProbe

REAR = ("rear_left", "rear_right")
WHEELS = ("front_left", "front_right", *REAR)
STEP = 5_000_000
DT = 0.005
SNOW, DRY = 1.9, 9.0
"""Decelerations [m/s^2]."""
Stop = list[tuple[float, str]]


def stop(deceleration: float = SNOW, held: float = 0.06, growth: float = 0.3, lowers: bool = True) -> Stop:
    """Brake from 30 m/s to rest; return when which wheel rolls.

    The standard deviation of the speed grows by `growth` [m/s] in a second, and is small when a wheel has rolled.
    """
    probe, rolling_for, since, found = SpeedProbe(REAR), 0, 0.0, []
    for k in range(round(30.0 / deceleration / DT)):
        time = k * DT
        speed = 30.0 - deceleration * time
        lowered = lowers and rolling_for > 8
        stddev = 0.05 + growth * (time - since)
        names = [
            wheel for wheel in WHEELS if probe.rolls(wheel, (k + 1) * STEP, speed, stddev, deceleration, lowered, held)
        ]
        assert len(names) <= 1
        rolling_for = rolling_for + 1 if names else 0
        since = time if rolling_for * DT > 0.15 else since
        found += [(time, name) for name in names]
    return found


def beginnings(found: Stop) -> Stop:
    times = [-1.0, *(time for time, _ in found)]
    return [each for each, before in zip(found, times, strict=False) if each[0] - before > 1.5 * DT]


def test_on_snow_one_rear_wheel_after_the_other_rolls_once_the_speed_is_unsure() -> None:
    found = beginnings(stop())
    assert [name for _, name in found][:3] == ["rear_left", "rear_right", "rear_left"]
    assert found[0][0] > 1.0
    assert 30.0 - SNOW * found[-1][0] > 5.0


def test_the_surer_the_speed_the_later_it_is_asked_for() -> None:
    first = [beginnings(stop(growth=growth))[0][0] for growth in (0.2, 0.4, 0.8)]
    assert first == sorted(first, reverse=True)
    assert not stop(growth=0.01)


def test_where_the_car_stands_soon_or_much_slip_is_held_none_rolls() -> None:
    assert not stop(DRY, held=0.17)
    assert not stop(7.5, held=0.13)


def test_no_wheel_rolls_that_is_not_kept_below_the_demand_nor_where_the_speed_may_not_be_asked_for() -> None:
    assert not stop(held=nan)
    probe = SpeedProbe(REAR)
    asked = [probe.rolls("rear_left", k * STEP, 25.0, nan, SNOW, False, 0.06) for k in range(1, 2000)]
    assert not any(asked)


def test_no_wheel_rolls_for_longer_than_a_third_of_a_second_whatever_is_measured() -> None:
    found = stop(lowers=False)
    lengths, starts = [time for time, _ in found], [time for time, _ in beginnings(found)]
    assert starts
    for start in starts:
        assert sum(start <= time < start + 1.0 for time in lengths) * DT <= 0.36


def test_a_wheel_that_is_not_heard_any_more_does_not_keep_the_turn() -> None:
    probe = SpeedProbe(REAR)
    assert probe.rolls("rear_left", STEP, 25.0, 2.0, SNOW, False, 0.06)
    after = (probe.rolls("rear_right", k * STEP, 25.0, 2.0, SNOW, False, 0.06) for k in range(2, 2000))
    assert any(after)
