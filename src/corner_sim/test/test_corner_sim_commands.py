"""Commands and demands that the plant accepts, and those it refuses."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from friction_msgs.msg import BrakeCommand, BrakeDemand
from std_msgs.msg import Header

from corner_sim.ros.commands import CommandInbox, DemandInbox
from friction_runtime.command_checksum import sealed
from vehicle_models.brake_actuator import Command

WHEELS = ("front_left", "front_right")
SECOND = 1_000_000_000
SAMPLE = 5_000_000


def command(
    order: int, stamp: int, counter: int = 1, wheel: str = "front_left", valid_for: float = 0.1
) -> BrakeCommand:
    header = Header(stamp=Time(sec=stamp // SECOND, nanosec=stamp % SECOND))
    return sealed(BrakeCommand(header=header, wheel=wheel, command=order, counter=counter, valid_for=valid_for))


def inbox_with(message: BrakeCommand) -> CommandInbox:
    inbox = CommandInbox(WHEELS)
    stamp = message.header.stamp
    assert inbox.take("front_left", message, stamp.sec * SECOND + stamp.nanosec) is None
    return inbox


def test_the_values_of_the_message_are_those_of_the_actuator() -> None:
    for order in Command:
        assert getattr(BrakeCommand, order.name) == order.value


def test_a_wheel_without_command_is_not_intervened_with() -> None:
    inbox = CommandInbox(WHEELS)
    assert inbox.take("front_right", command(BrakeCommand.DECREASE, SECOND, wheel="front_right"), SECOND) is None
    assert inbox.commands(SECOND).tolist() == [Command.NONE, Command.DECREASE]


@pytest.mark.parametrize("valid_for", [0.02, 0.1, 1.0])
def test_a_command_holds_as_long_as_it_says_itself_and_then_counts_as_none_and_is_named(valid_for: float) -> None:
    inbox = inbox_with(command(BrakeCommand.DECREASE, SECOND, valid_for=valid_for))
    end = SECOND + round(valid_for * SECOND)
    assert inbox.commands(end).tolist() == [Command.DECREASE, Command.NONE]
    assert inbox.expired(end) == []
    assert inbox.commands(end + 1).tolist() == [Command.NONE, Command.NONE]
    assert inbox.expired(end + 1) == ["front_left"]


def test_a_heartbeat_for_the_same_sample_is_taken_and_does_not_make_it_hold_longer() -> None:
    inbox = inbox_with(command(BrakeCommand.DECREASE, SECOND, counter=1))
    for beat in range(2, 7):
        now = SECOND + (beat - 1) * 20_000_000
        assert inbox.take("front_left", command(BrakeCommand.DECREASE, SECOND, counter=beat), now) is None
    assert inbox.commands(SECOND + 100_000_001).tolist() == [Command.NONE, Command.NONE]


def test_the_newest_of_the_commands_for_one_sample_is_obeyed() -> None:
    inbox = inbox_with(command(BrakeCommand.DECREASE, SECOND, counter=1))
    assert inbox.take("front_left", command(BrakeCommand.NONE, SECOND, counter=2), SECOND) is None
    assert inbox.commands(SECOND).tolist() == [Command.NONE, Command.NONE]


def test_a_command_that_arrives_after_its_end_is_refused_and_named() -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND, counter=1))
    now = SECOND + 60 * SAMPLE
    refusal = inbox.take("front_left", command(BrakeCommand.DECREASE, SECOND + 30 * SAMPLE, counter=2), now)
    assert refusal is not None
    assert "0.150 s old" in refusal
    assert inbox.commands(now).tolist() == [Command.NONE, Command.NONE]


@pytest.mark.parametrize(
    ("stamp", "counter"),
    [
        (SECOND, 7),  # the same message twice
        (SECOND + SAMPLE, 7),  # an old message with a new stamp: its sender does not count
        (SECOND, 6),
        (SECOND - SAMPLE, 6),
        (SECOND - SAMPLE, 8),
    ],
)
def test_an_old_or_repeated_command_is_refused_by_its_counter_and_changes_nothing(stamp: int, counter: int) -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND, counter=7))
    refusal = inbox.take("front_left", command(BrakeCommand.DECREASE, stamp, counter), SECOND + SAMPLE)
    assert refusal is not None
    assert "front_left/brake_command" in refusal
    assert f"counter {counter}" in refusal
    assert inbox.commands(SECOND + SAMPLE).tolist() == [Command.HOLD, Command.NONE]
    assert inbox.new_senders == 0


def test_a_supervisor_that_was_started_again_is_obeyed_from_its_first_answer_to_a_newer_sample() -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND, counter=5000))
    now = SECOND + 400 * SAMPLE
    assert inbox.take("front_left", command(BrakeCommand.DECREASE, now, counter=1), now) is None
    assert inbox.commands(now).tolist() == [Command.DECREASE, Command.NONE]
    assert (inbox.new_senders, inbox.lost) == (1, 0)


def test_the_counter_wraps_around() -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND, counter=2**32 - 1))
    assert inbox.take("front_left", command(BrakeCommand.DECREASE, SECOND, counter=0), SECOND) is None
    assert inbox.commands(SECOND).tolist() == [Command.DECREASE, Command.NONE]
    assert (inbox.new_senders, inbox.lost) == (0, 0)


def test_commands_that_the_counter_shows_to_be_missing_are_counted() -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND, counter=5))
    assert inbox.take("front_left", command(BrakeCommand.HOLD, SECOND + SAMPLE, counter=9), SECOND + SAMPLE) is None
    assert inbox.lost == 3


def test_lock_step_waits_for_the_command_with_exactly_the_last_stamp() -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND))
    assert inbox.unanswered(SECOND) == ["front_right"]
    inbox.take("front_right", command(BrakeCommand.HOLD, SECOND - SAMPLE, 1, "front_right"), SECOND)
    assert inbox.unanswered(SECOND) == ["front_right"]
    inbox.take("front_right", command(BrakeCommand.HOLD, SECOND, 2, "front_right"), SECOND)
    assert inbox.unanswered(SECOND) == []
    assert inbox.unanswered(SECOND + SAMPLE) == list(WHEELS)


@pytest.mark.parametrize(
    ("message", "named"),
    [
        (command(BrakeCommand.DECREASE, SECOND, 2, "rear_left"), "rear_left"),
        (command(4, SECOND, 2), "unknown command 4"),
        (command(BrakeCommand.DECREASE, 0, 2), "stamp is zero"),
        (command(BrakeCommand.DECREASE, SECOND + 1, 2), "ahead of the plant"),
        *(
            (command(BrakeCommand.DECREASE, SECOND, 2, valid_for=valid_for), "valid_for")
            for valid_for in (0.0, -0.1, 1.001, math.nan, math.inf)
        ),
    ],
)
def test_a_bad_command_is_refused_with_its_topic_and_changes_nothing(message: BrakeCommand, named: str) -> None:
    inbox = inbox_with(command(BrakeCommand.HOLD, SECOND))
    refusal = inbox.take("front_left", message, SECOND)
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


@pytest.mark.parametrize(
    ("field", "value"), [("command", BrakeCommand.DECREASE), ("counter", 7), ("valid_for", 0.5), ("checksum", 0)]
)
def test_a_command_that_was_changed_on_the_way_is_refused(field: str, value: float) -> None:
    message, inbox = command(BrakeCommand.HOLD, SECOND), CommandInbox(WHEELS)
    setattr(message, field, value)
    assert "checksum" in (inbox.take("front_left", message, SECOND) or "")
    assert inbox.commands(SECOND).tolist() == [BrakeCommand.NONE] * 2
