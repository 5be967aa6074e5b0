"""Commands and demands that the plant accepts, and those it refuses."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from friction_msgs.msg import BrakeCommand, BrakeDemand
from std_msgs.msg import Header

from corner_sim.commands import CommandInbox, DemandInbox
from vehicle_models.brake_actuator import Command

WHEELS = ("front_left", "front_right")
SECOND = 1_000_000_000


def command(wheel: str, order: int, stamp: int) -> BrakeCommand:
    header = Header(stamp=Time(sec=stamp // SECOND, nanosec=stamp % SECOND))
    return BrakeCommand(header=header, wheel=wheel, command=order)


def test_the_values_of_the_message_are_those_of_the_actuator() -> None:
    for order in Command:
        assert getattr(BrakeCommand, order.name) == order.value


def test_a_wheel_without_command_is_not_intervened_with() -> None:
    inbox = CommandInbox(WHEELS, 0.1)
    assert inbox.take("front_right", command("front_right", BrakeCommand.DECREASE, SECOND)) is None
    assert inbox.commands(SECOND).tolist() == [Command.NONE, Command.DECREASE]


def test_a_command_that_ages_beyond_the_time_out_counts_as_none_and_is_named() -> None:
    inbox = CommandInbox(WHEELS, 0.1)
    inbox.take("front_left", command("front_left", BrakeCommand.DECREASE, SECOND))
    assert inbox.commands(SECOND + 100_000_000).tolist() == [Command.DECREASE, Command.NONE]
    assert inbox.stale(SECOND + 100_000_000) == []
    assert inbox.commands(SECOND + 100_000_001).tolist() == [Command.NONE, Command.NONE]
    assert inbox.stale(SECOND + 100_000_001) == ["front_left"]


def test_lock_step_waits_for_the_command_with_exactly_the_last_stamp() -> None:
    inbox = CommandInbox(WHEELS, 0.1)
    inbox.take("front_left", command("front_left", BrakeCommand.HOLD, SECOND))
    assert inbox.unanswered(SECOND) == ["front_right"]
    inbox.take("front_right", command("front_right", BrakeCommand.HOLD, SECOND - 5_000_000))
    assert inbox.unanswered(SECOND) == ["front_right"]
    inbox.take("front_right", command("front_right", BrakeCommand.HOLD, SECOND))
    assert inbox.unanswered(SECOND) == []
    assert inbox.unanswered(SECOND + 5_000_000) == list(WHEELS)


@pytest.mark.parametrize(
    ("message", "named"),
    [
        (command("rear_left", BrakeCommand.DECREASE, SECOND), "rear_left"),
        (command("front_left", 4, SECOND), "unknown command 4"),
        (command("front_left", BrakeCommand.DECREASE, 0), "stamp is zero"),
    ],
)
def test_a_bad_command_is_refused_with_its_topic_and_changes_nothing(message: BrakeCommand, named: str) -> None:
    inbox = CommandInbox(WHEELS, 0.1)
    inbox.take("front_left", command("front_left", BrakeCommand.HOLD, SECOND))
    refusal = inbox.take("front_left", message)
    assert refusal is not None
    assert "front_left/brake_command" in refusal
    assert named in refusal
    assert inbox.commands(SECOND).tolist() == [Command.HOLD, Command.NONE]


def test_a_demand_is_for_one_wheel_or_for_all() -> None:
    inbox = DemandInbox(WHEELS)
    assert inbox.take(BrakeDemand(pressure=2e6)) is None
    assert inbox.take(BrakeDemand(wheel="front_right", pressure=1e6)) is None
    np.testing.assert_array_equal(inbox.pressure, [2e6, 1e6])


@pytest.mark.parametrize(
    "message",
    [
        BrakeDemand(pressure=float("nan")),
        BrakeDemand(pressure=float("inf")),
        BrakeDemand(pressure=-1.0),
        BrakeDemand(wheel="spare", pressure=1.0),
    ],
)
def test_a_bad_demand_is_refused_by_name_and_changes_nothing(message: BrakeDemand) -> None:
    inbox = DemandInbox(WHEELS)
    inbox.take(BrakeDemand(pressure=2e6))
    refusal = inbox.take(message)
    assert refusal is not None
    assert "brake_demand" in refusal
    np.testing.assert_array_equal(inbox.pressure, [2e6, 2e6])
