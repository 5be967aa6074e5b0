"""The wheels of an axle: what one may have once the other was released on its own evidence."""

from dataclasses import replace
from math import inf, nan

import pytest

from abs_supervisor.axle import NO_AXLE, Axle, axles
from vehicle_models.brake_actuator import Command
from vehicle_models.vehicle import FRONT
from vehicle_models.vehicle_file import load_vehicle

STEP = 5_000_000
SECOND = 1_000_000_000
LOW, HIGH = "left", "right"
COMPACT = load_vehicle("compact_car")


def pair(select_low: bool = True, growth: float = inf) -> Axle:
    return Axle((LOW, HIGH), select_low, growth)


def told(found: Axle, torque: float = 100.0, released: bool = True, command: Command = Command.DECREASE) -> Axle:
    """The low wheel speaks for 0.1 s, up to the stamp 20 STEP."""
    for k in range(21):
        found.note(LOW, k * STEP, torque, command, released)
    return found


NOW = 22 * STEP


@pytest.mark.parametrize(
    ("torque", "expected"),
    [(90.0, Command.INCREASE), (115.0, Command.INCREASE), (130.0, Command.HOLD), (300.0, Command.DECREASE)],
)
def test_select_low_brings_a_wheel_down_to_the_other(torque: float, expected: Command) -> None:
    assert told(pair()).most(HIGH, NOW, torque) is expected


def test_the_lower_wheel_is_left_alone() -> None:
    found = told(pair())
    found.note(HIGH, 20 * STEP, 300.0, Command.DECREASE, released=False)
    assert found.most(LOW, NOW, 100.0) is Command.INCREASE


def test_without_a_release_of_the_other_on_its_own_evidence_nothing_is_taken_away() -> None:
    """A brake that leaks or a pressure that is not built up takes none from the healthy side."""
    assert told(pair(), torque=0.0, released=False, command=Command.INCREASE).most(HIGH, NOW, 900.0) is Command.INCREASE


@pytest.mark.parametrize("last", [Command.NONE, Command.DECREASE])
def test_a_wheel_that_the_driver_has_back_or_whose_torque_is_not_known_limits_nothing(last: Command) -> None:
    found = told(pair())
    found.note(LOW, 21 * STEP, nan if last is Command.DECREASE else 100.0, last, released=True)
    assert found.most(HIGH, 24 * STEP, 900.0) is Command.INCREASE


def test_a_wheel_that_is_heard_of_no_more_limits_nothing() -> None:
    assert told(pair()).most(HIGH, 20 * STEP + SECOND // 10, 900.0) is Command.INCREASE


def test_it_does_not_matter_which_wheel_of_a_sample_is_asked_first() -> None:
    early, late = told(pair()), told(pair())
    late.note(LOW, NOW, 900.0, Command.INCREASE, released=False)
    assert early.most(HIGH, NOW, 300.0) is late.most(HIGH, NOW, 300.0)


def test_a_limit_of_the_moment_lets_the_difference_grow_and_releases_nothing() -> None:
    """500 N m/s from the release at 0 on: 55 N m after 0.11 s, and the band."""
    found = told(pair(select_low=False, growth=500.0))
    assert found.most(HIGH, NOW, 170.0) is Command.INCREASE
    assert found.most(HIGH, NOW, 180.0) is Command.HOLD
    assert found.most(HIGH, NOW, 2000.0) is Command.HOLD
    for k in range(21, 121):
        found.note(LOW, k * STEP, 100.0, Command.HOLD, released=False)
    assert found.most(HIGH, 122 * STEP, 400.0) is Command.INCREASE


def test_where_the_speed_comes_from_the_wheels_alone_the_axle_is_controlled_select_low() -> None:
    found = told(pair(select_low=False))
    assert found.most(HIGH, NOW, 900.0) is Command.INCREASE
    assert found.most(HIGH, NOW, 900.0, degraded=True) is Command.DECREASE


def test_each_wheel_shares_its_axle_with_the_other() -> None:
    found = axles(COMPACT, NO_AXLE)
    assert set(found) == set(COMPACT.wheel_names)
    assert len({id(each) for each in found.values()}) == 2


def test_a_moment_of_the_vehicle_file_is_a_difference_of_torques() -> None:
    """M = (T_left - T_right) / r track / 2."""
    limited = replace(COMPACT, front_yaw_moment_rate=1000.0)
    low, high = (wheel for wheel in COMPACT.wheels if wheel.axle == FRONT)
    found = axles(limited, NO_AXLE)[low.name]
    for k in range(201):
        found.note(low.name, k * STEP, 100.0, Command.DECREASE, released=True)
    allowed = 1000.0 * 1.01 * 2.0 * low.radius / COMPACT.track
    assert found.most(high.name, 202 * STEP, 100.0 + allowed + 15.0) is Command.INCREASE
    assert found.most(high.name, 202 * STEP, 100.0 + allowed + 25.0) is Command.HOLD
