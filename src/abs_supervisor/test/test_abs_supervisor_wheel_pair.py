"""The wheels of an axle: what one may have once the other was released on its own evidence."""

from dataclasses import replace
from math import nan

import pytest

from abs_supervisor.guard import Guard, Seen
from abs_supervisor.tuning import EnvelopeTuning
from abs_supervisor.wheel_pair import NO_AXLE, WheelPair, wheel_pairs
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import FRONT, REAR
from vehicle_models.vehicle_file import load_vehicle

STEP = 5_000_000
SECOND = 1_000_000_000
LOW, HIGH = "left", "right"
COMPACT = load_vehicle("compact_car")


def pair(releases: bool = True, growth: float = 0.0) -> WheelPair:
    return WheelPair((LOW, HIGH), releases, growth)


def told(
    found: WheelPair, torque: float = 100.0, released: bool = True, command: Command = Command.DECREASE
) -> WheelPair:
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
    found = told(pair(releases=False, growth=500.0))
    assert found.most(HIGH, NOW, 170.0) is Command.INCREASE
    assert found.most(HIGH, NOW, 180.0) is Command.HOLD
    assert found.most(HIGH, NOW, 2000.0) is Command.HOLD
    for k in range(21, 121):
        found.note(LOW, k * STEP, 100.0, Command.HOLD, released=False)
    assert found.most(HIGH, 122 * STEP, 400.0) is Command.INCREASE


def test_pairs_are_those_of_the_parameter_and_of_the_vehicle_file() -> None:
    assert not wheel_pairs(COMPACT, NO_AXLE)
    assert set(wheel_pairs(COMPACT, REAR)) == {wheel.name for wheel in COMPACT.wheels if wheel.axle == REAR}
    limited = replace(COMPACT, front_yaw_moment_rate=5000.0)
    found = wheel_pairs(limited, NO_AXLE)
    assert set(found) == {wheel.name for wheel in COMPACT.wheels if wheel.axle == FRONT}
    assert len({id(each) for each in found.values()}) == 1


def test_a_moment_of_the_vehicle_file_is_a_difference_of_torques() -> None:
    """M = (T_left - T_right) / r track / 2."""
    limited = replace(COMPACT, front_yaw_moment_rate=1000.0)
    low, high = (wheel for wheel in COMPACT.wheels if wheel.axle == FRONT)
    found = wheel_pairs(limited, NO_AXLE)[low.name]
    for k in range(201):
        found.note(low.name, k * STEP, 100.0, Command.DECREASE, released=True)
    allowed = 1000.0 * 1.01 * 2.0 * low.radius / COMPACT.track
    assert found.most(high.name, 202 * STEP, 100.0 + allowed + 15.0) is Command.INCREASE
    assert found.most(high.name, 202 * STEP, 100.0 + allowed + 25.0) is Command.HOLD


@pytest.mark.parametrize("most", [Command.INCREASE, Command.HOLD, Command.DECREASE])
@pytest.mark.parametrize("law", [Command.NONE, Command.INCREASE])
def test_a_wheel_gets_no_more_than_the_other_leaves_but_the_drivers_brake_is_his(law: Command, most: Command) -> None:
    wheel = COMPACT.wheels[0]
    guard = Guard(COMPACT.corner(wheel.name), EnvelopeTuning(), ActuatorParameters(), commands=True)
    seen = Seen(wheel_speed=20.0 / wheel.radius, torque=300.0, demand=800.0, car_speed=20.0, slip=0.0)
    guard.look(STEP, seen)
    assert guard.command(STEP, law, most) is (Command.NONE if law is Command.NONE else most)
