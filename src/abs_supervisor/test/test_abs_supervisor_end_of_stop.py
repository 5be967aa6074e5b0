"""The end of a stop: where a dive is faster than the brake, the pressure is not raised to the peak again."""

from math import nan

import pytest

from abs_supervisor.end_of_stop import EndOfStop
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import CornerParameters

DRY, SNOW = 1800.0, 300.0
"""Brake torque at the peak of a front wheel of a car [N m]."""
SLOW = 7.0
"""[m/s] a dive on dry takes 75 ms there, and the brake 130 ms."""


def end_of_stop(release_rate: float = 5000.0) -> EndOfStop:
    corner = CornerParameters(radius=0.3, inertia=1.0, mass=375.0, vertical_load=3678.75)
    return EndOfStop(corner, ActuatorParameters(release_rate=release_rate))


def asked(
    *given: Command,
    machine: Command = Command.INCREASE,
    grips: bool = True,
    speed: float = SLOW,
    torque: float = DRY,
    release_rate: float = 5000.0,
) -> Command:
    end = end_of_stop(release_rate)
    for each in given:
        end.commanded(each)
    return end.ask(machine, grips, speed, torque)


def test_a_wheel_that_was_released_is_kept_at_the_slip_of_a_release() -> None:
    assert asked(Command.DECREASE, Command.INCREASE) is Command.HOLD


@pytest.mark.parametrize("given", [[], [Command.INCREASE, Command.HOLD], [Command.DECREASE, Command.NONE]])
def test_a_braking_without_a_release_is_left_alone(given: list[Command]) -> None:
    assert asked(*given) is Command.INCREASE


def test_below_the_slip_of_a_release_the_pressure_rises() -> None:
    assert asked(Command.DECREASE, grips=False) is Command.INCREASE


@pytest.mark.parametrize("machine", [Command.NONE, Command.HOLD, Command.DECREASE])
def test_only_a_rise_of_the_pressure_is_changed(machine: Command) -> None:
    assert asked(Command.DECREASE, machine=machine) is machine


@pytest.mark.parametrize(
    ("speed", "torque", "release_rate", "expected"),
    [
        (15.0, DRY, 5000.0, Command.INCREASE),
        (12.0, DRY, 5000.0, Command.HOLD),
        (SLOW, SNOW, 5000.0, Command.INCREASE),
        (SLOW, DRY, 20_000.0, Command.INCREASE),
        (nan, DRY, 5000.0, Command.INCREASE),
        (SLOW, nan, 5000.0, Command.INCREASE),
    ],
)
def test_it_applies_where_a_dive_takes_less_time_than_the_brake(
    speed: float, torque: float, release_rate: float, expected: Command
) -> None:
    assert asked(Command.DECREASE, speed=speed, torque=torque, release_rate=release_rate) is expected


def test_reset_forgets_the_release() -> None:
    end = end_of_stop()
    end.commanded(Command.DECREASE)
    end.reset()
    assert end.ask(Command.INCREASE, True, SLOW, DRY) is Command.INCREASE
