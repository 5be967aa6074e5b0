"""Fail-safe by the clock: which lost input ends a release within 50 ms and its period, and when ABS is back."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf, nan
from typing import Any

import pytest
from friction_msgs.msg import (
    BrakeCommand,
    BrakeDemand,
    SlopeVote,
    SupervisorDebug,
    SupervisorState,
    Validity,
    WheelSlip,
)
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.ros.processor import WheelProcessor
from abs_supervisor.state_machine import Thresholds
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_runtime.processor import Level
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

WHEEL = "front_left"
WHEEL_STATES, PRESSURE = "wheel_states", f"{WHEEL}/brake_pressure"
DEMAND, VOTE = "brake_demand", f"{WHEEL}/slope_vote"
LOST = {
    WHEEL_STATES: Reason.NO_WHEEL_SPEED,
    PRESSURE: Reason.NO_PRESSURE,
    DEMAND: Reason.NO_DEMAND,
    VOTE: Reason.NO_SLOPE,
}
SLIP = f"{WHEEL}/slip"
PERIODS = {WHEEL_STATES: 5, PRESSURE: 5, DEMAND: 20, SLIP: 5, VOTE: 5}
"""Of the messages [ms]."""
VEHICLE = load_vehicle("chapter_corner")
P = SupervisorParameters(
    shadow=False, thresholds=Thresholds(h_instability=-100.0, h_stability=1000.0, wait=0.04, release_timeout=10.0)
)
BOOT, START = 777.0, 5_000_000_000_000
"""The steady clock [s] and the stamps [ns] when a test begins."""


def message(topic: str, stamp: int, wheel_speed: float | None = None) -> Any:
    if wheel_speed is None:  # a sensor that turns does not repeat itself
        wheel_speed = 80.0 + 0.01 * (stamp // 5_000_000 % 7)
    header = Header(stamp=from_nanoseconds(max(stamp, 0)))
    if topic == WHEEL_STATES:
        return JointState(header=header, name=[WHEEL], velocity=[wheel_speed])
    if topic == PRESSURE:
        return FluidPressure(header=header, fluid_pressure=4e6)
    if topic == DEMAND:
        return BrakeDemand(header=header, pressure=5e6)
    if topic == SLIP:
        return WheelSlip(
            header=header, slip=0.04, vehicle_speed=25.0, wheel_speed=wheel_speed, validity=Validity(valid=True)
        )
    return SlopeVote(header=header, h=500.0, indicator=500.0, validity=Validity(valid=True))


Fault = Callable[[str, int, int], Any]
"""Makes the message of a topic that is due, in place of the good one: topic, time since START and time of loss [ms]."""


@dataclass
class Bench:
    """A supervisor of one wheel, its four inputs and a node's clock, in steps of 1 ms; it always brakes."""

    parameters: SupervisorParameters = P
    now: int = 0
    """Time since the begin [ms]."""
    commands: list[tuple[int, BrakeCommand]] = field(default_factory=list)
    """With the time at which they came [ms]."""
    state: SupervisorState = field(default_factory=SupervisorState)
    debug: SupervisorDebug = field(default_factory=SupervisorDebug)

    def __post_init__(self) -> None:
        self.said: list[str] = []
        self.processor = WheelProcessor(WHEEL, VEHICLE, self.parameters, lambda _severity, text: self.said.append(text))
        self._came = dict.fromkeys(PERIODS, -inf)

    def take(self, outputs: Any) -> None:
        for topic, answer in outputs:
            if topic.endswith("brake_command"):
                self.commands.append((self.now, answer))
            elif topic.endswith("abs_supervisor"):
                self.state = answer
            else:
                self.debug = answer

    def give(self, topic: str, given: Any) -> None:
        self._came[topic] = self.now
        self.take(self.processor.process(topic, given))

    def watch(self) -> None:
        ages = {topic: (self.now - came) * 1e-3 for topic, came in self._came.items()}
        self.take(self.processor.watch(ages, BOOT + self.now * 1e-3))

    def run(self, until: int, fault: Fault | None = None, lost: str = "", poll_phase: int = 3) -> None:
        """Run to a time [ms]; from now on `fault` makes the messages of the topic `lost`, or none where it is None."""
        begin = self.now
        while self.now < until:
            self.now += 1
            for topic, period in PERIODS.items():
                if self.now % period == 0:
                    good = message(topic, START + self.now * 1_000_000)
                    given = good if topic != lost else fault(topic, self.now, begin) if fault else None
                    if given is not None:
                        self.give(topic, given)
            if self.now % 10 == poll_phase:
                self.watch()

    @property
    def newest(self) -> int:
        return int(self.commands[-1][1].command)


def repeats(topic: str, now: int, begin: int) -> Any:
    return message(topic, START + (begin - begin % PERIODS[topic]) * 1_000_000)


def zero(topic: str, now: int, begin: int) -> Any:
    return message(topic, 0)


def back(topic: str, now: int, begin: int) -> Any:
    return message(topic, START + (now - PERIODS[topic] - 50) * 1_000_000)


def crawls(topic: str, now: int, begin: int) -> Any:
    return message(topic, START + begin * 1_000_000 + (now - begin) * 1000)


@pytest.mark.parametrize("poll_phase", [0, 3, 6, 9])
@pytest.mark.parametrize("fault", [None, repeats, zero, back, crawls])
@pytest.mark.parametrize("lost", list(LOST))
def test_a_lost_input_brings_none_within_50_ms_and_its_period(lost: str, fault: Fault | None, poll_phase: int) -> None:
    bench = Bench()
    bench.run(1000, poll_phase=poll_phase)
    assert bench.newest == BrakeCommand.INCREASE
    bench.run(1300, fault, lost, poll_phase)
    found = [k for k, (at, command) in enumerate(bench.commands) if at > 1000 and command.command == BrakeCommand.NONE]
    assert bench.commands[found[0]][0] - 1000 <= 50 + PERIODS[lost]
    assert len(found) == len(bench.commands) - found[0], "and none but NONE follows"
    assert bench.state.validity.reason == LOST[lost]
    assert bench.state.validity.text.startswith((f"{lost}: ", f"{WHEEL}: {lost}: "))
    assert not bench.state.validity.valid
    assert bench.processor.health().level is Level.ERROR
    assert lost in bench.processor.health().message
    assert [text for text in bench.said if text.endswith("fail-safe")]
    bench.run(2100, poll_phase=poll_phase)
    assert bench.newest == BrakeCommand.INCREASE, "the input is back"


@pytest.mark.parametrize("lost", list(LOST))
def test_an_input_whose_clock_was_set_alone_stays_lost_until_it_is_that_of_the_others_again(lost: str) -> None:
    """Its stamps progress with the clock, but samples of different times are paired by them."""
    bench = Bench()
    bench.run(1000)
    bench.run(3000, back, lost)
    assert {command.command for at, command in bench.commands if at > 1070} == {BrakeCommand.NONE}
    assert bench.state.validity.reason == LOST[lost]
    assert f"{lost}: stamps are 0.0{50 + PERIODS[lost]} s behind those of " in bench.state.validity.text
    bench.run(3700)
    assert bench.newest == BrakeCommand.INCREASE


def test_garbage_is_no_progress() -> None:
    garbage: dict[str, Fault] = {
        WHEEL_STATES: lambda topic, now, _: message(topic, START + now * 1_000_000, nan),
        PRESSURE: lambda topic, now, _: FluidPressure(
            header=Header(stamp=from_nanoseconds(START + now * 1_000_000)), fluid_pressure=nan
        ),
        DEMAND: lambda topic, now, _: BrakeDemand(
            header=Header(stamp=from_nanoseconds(START + now * 1_000_000)), pressure=nan
        ),
    }
    for lost, fault in garbage.items():
        bench = Bench()
        bench.run(1000)
        bench.run(1000 + 49 + PERIODS[lost], fault, lost)
        assert bench.newest == BrakeCommand.NONE
        assert bench.state.validity.reason == LOST[lost]


def test_a_supervisor_that_starts_into_braking_or_stood_back_for_a_loss_does_not_blame_the_pressure() -> None:
    bench = Bench()
    bench.run(400)
    assert (bench.newest, bench.state.validity.reason) == (BrakeCommand.INCREASE, Reason.OK)
    bench.run(700, None, DEMAND)
    assert bench.newest == BrakeCommand.NONE
    bench.run(900)
    assert (bench.newest, bench.state.validity.reason) == (BrakeCommand.INCREASE, Reason.OK)


def test_a_wheel_that_stands_with_new_stamps_is_not_lost() -> None:
    bench = Bench()
    bench.run(1000)
    bench.run(2000, lambda topic, now, _: message(topic, START + now * 1_000_000, 0.0), WHEEL_STATES)
    assert bench.state.validity.reason != Reason.NO_WHEEL_SPEED


def test_the_demand_of_another_wheel_is_none_for_this_one() -> None:
    bench = Bench()
    bench.run(1000)
    bench.run(
        1100,
        lambda topic, now, _: BrakeDemand(
            header=Header(stamp=from_nanoseconds(START + now * 1_000_000)), pressure=5e6, wheel="rear_left"
        ),
        DEMAND,
    )
    assert bench.state.validity.reason == Reason.NO_DEMAND


def test_commands_are_a_heartbeat_that_counts() -> None:
    bench = Bench()
    bench.run(1000)
    bench.run(1500, None, VOTE)
    times = [at for at, _ in bench.commands]
    assert max(b - a for a, b in pairwise(times)) <= 20
    counters = [command.counter for _, command in bench.commands]
    assert counters == list(range(1, len(counters) + 1))
    assert {command.valid_for for _, command in bench.commands} == {P.valid_for}


def test_after_a_stop_nothing_old_is_answered_and_abs_is_back_within_a_fifth_of_a_second() -> None:
    bench = Bench()
    bench.run(1000)
    answered, before = bench.state.header.stamp, len(bench.commands)
    waiting = [(topic, at) for at in range(2500, 3000) for topic, period in PERIODS.items() if at % period == 0]
    bench.now = 3000
    bench.watch()  # a node looks at the clock before it hands on what has waited
    assert bench.newest == BrakeCommand.NONE
    for topic, at in waiting:
        bench.give(topic, message(topic, START + at * 1_000_000))
    old = [command for _, command in bench.commands[before:] if command.header.stamp != answered]
    assert all(to_nanoseconds(command.header.stamp) >= START + 2_950_000_000 for command in old)
    assert {command.command for _, command in bench.commands[before:]} == {BrakeCommand.NONE}
    bench.run(3200)
    assert bench.newest == BrakeCommand.INCREASE


@pytest.mark.parametrize("by", [1000, 3_600_000])
def test_a_clock_that_leaps_ahead_everywhere_costs_half_a_second_at_most(by: int) -> None:
    bench = Bench()
    bench.run(1000)
    for at in range(1001, 2001):
        bench.now = at
        for topic, period in PERIODS.items():
            if at % period == 0:
                bench.give(topic, message(topic, START + (at + by) * 1_000_000))
        if at % 10 == 3:
            bench.watch()
    none = [at for at, command in bench.commands if at > 1000 and command.command == BrakeCommand.NONE]
    assert max(none, default=0) < 1600
    assert bench.newest == BrakeCommand.INCREASE


@pytest.mark.parametrize("lost", list(PERIODS))
@pytest.mark.parametrize("demand_period", [5, 20, 33])
def test_a_sample_that_is_lost_on_the_way_changes_nothing(
    lost: str, demand_period: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PERIODS, DEMAND, demand_period)
    bench = Bench()
    bench.run(1000)
    begun = len(bench.commands)
    for at in range(1000, 2000, 200):
        bench.run(at + PERIODS[lost], None, lost)
        bench.run(at + 200)
    assert {command.command for _, command in bench.commands[begun:]} == {BrakeCommand.INCREASE}
    assert bench.debug.fail_safes == 0
    assert bench.state.validity.reason == Reason.OK


@pytest.mark.parametrize("parameters", [replace(P, shadow=True), replace(P, real_time=False)])
def test_where_stamps_need_not_follow_the_clock_only_silence_counts(parameters: SupervisorParameters) -> None:
    bench = Bench(parameters)
    for at in range(1, 401):  # half as fast as the clock
        bench.now = at
        for topic, period in PERIODS.items():
            if at % (2 * period) == 0:
                bench.give(topic, message(topic, START + at * 500_000))
        if at % 10 == 3:
            bench.watch()
    assert bench.state.state == SupervisorState.S1
    assert len(bench.commands) == (0 if parameters.shadow else 40), "no heartbeat but an answer to each sample"


def test_a_dead_wheel_slip_is_named_though_the_law_goes_on() -> None:
    bench = Bench()
    bench.run(1000)
    ages = {topic: 0.001 for topic in LOST}
    bench.processor.watch({**ages, f"{WHEEL}/slip": 0.4}, BOOT + 1.005)
    assert bench.processor.health().level is Level.WARN
    assert f"{WHEEL}/slip: no message for 0.40 s" in bench.processor.health().message
