"""Bad input to the real graph over DDS: named, marked invalid, survived; and the reset of everything."""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any

import pytest
from friction_msgs.msg import BrakeCommand, BrakeDemand, FrictionSlope, SlopeVote, SupervisorState, Validity, WheelSlip
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from campaigns.live.part import LOOP
from friction_bags.bag_io.cdr import encode
from friction_bringup import graph
from friction_runtime import qos
from friction_runtime.installed import shipped_file
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client
from vehicle_models.reason import Reason

WHEEL = "front_left"
OUTPUTS: Mapping[str, type] = {
    f"{WHEEL}/slip": WheelSlip,
    f"{WHEEL}/friction_slope": FrictionSlope,
    f"{WHEEL}/slope_vote": SlopeVote,
    f"{WHEEL}/abs_supervisor": SupervisorState,
    f"{WHEEL}/brake_command": BrakeCommand,
}
EVERYTHING = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
"""Nothing is lost while a plant that runs as fast as possible is ahead of the test."""
START = 1_000_000_000
PERIOD = 5_000_000


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


def start(client: DdsClient, node: str, *extra: str, **parameters: graph.ParameterValue) -> subprocess.Popen[str]:
    """Start a node with its shipped parameter file, the demo's car, some parameters and further ROS arguments."""
    command = graph.command(node, [shipped_file(node)], {"vehicle_file": "chapter_corner", **parameters})
    return client.start(*command[1:], *extra)


def start_estimators(client: DdsClient, stale_after: float = 0.1) -> list[subprocess.Popen[str]]:
    supervisor = {"shadow": False, "stale_after": stale_after, "real_time": False}
    return [start(client, node, **(supervisor if node == "abs_supervisor" else {})) for node in LOOP]


def record(client: DdsClient) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {topic: [] for topic in OUTPUTS}
    for topic, kind in OUTPUTS.items():
        qos.subscribe(client.node, kind, topic, found[topic].append, EVERYTHING)
    return found


def assert_in_order(found: Mapping[str, list[Any]]) -> None:
    """No estimate repeats a stamp; the supervisor does when it acts on silence between two samples."""
    for topic, received in found.items():
        stamps = [to_nanoseconds(message.header.stamp) for message in received]
        estimate = topic.endswith(("/slip", "/friction_slope", "/slope_vote"))
        assert all(a < b if estimate else a <= b for a, b in pairwise(stamps)), topic


class Car:
    """A car that the test drives at a steady 20 m/s, brake pressed, with any values in place of the right ones."""

    def __init__(self, client: DdsClient) -> None:
        node = client.node
        self._client = client
        self._wheel_states = qos.publish(node, JointState, "wheel_states")
        self._pressure = qos.publish(node, FluidPressure, f"{WHEEL}/brake_pressure")
        self._imu = qos.publish(node, Imu, "imu/data")
        self._demand = qos.publish(node, BrakeDemand, "brake_demand")
        self.sample = 0
        client.until(lambda: node.count_subscribers("wheel_states") >= len(LOOP))
        client.until(lambda: self._pressure.get_subscription_count() >= 1)
        client.until(lambda: all(node.count_publishers(topic) == 1 for topic in OUTPUTS))

    def drive(
        self, samples: int, wheel_speed: float = 20.0 / 0.3, pressure: float = 4e6, repeat_stamp: bool = False
    ) -> None:
        for _ in range(samples):
            if not repeat_stamp:
                self.sample += 1
            header = Header(stamp=from_nanoseconds(START + self.sample * PERIOD))
            self._demand.publish(BrakeDemand(header=header, pressure=4e6))
            self._imu.publish(Imu(header=header))
            self._pressure.publish(FluidPressure(header=header, fluid_pressure=pressure))
            self._wheel_states.publish(JointState(header=header, name=[WHEEL], velocity=[wheel_speed]))
            until = time.monotonic() + 0.005
            while (left := until - time.monotonic()) > 0.0:
                self._client.executor.spin_once(timeout_sec=left)

    def drive_until_answered(self, received: list[Any]) -> None:
        """Drive on until the newest sample is answered: best-effort samples may be lost, this one is not."""

        def answered() -> bool:
            self.drive(1)
            return bool(received) and to_nanoseconds(received[-1].header.stamp) == self.stamp

        self._client.until(answered)

    @property
    def stamp(self) -> int:
        return START + self.sample * PERIOD


def test_a_dead_pressure_topic_is_named_and_nothing_is_commanded(client: DdsClient) -> None:
    processes = start_estimators(client)
    found = record(client)
    start(
        client, "corner_sim", "-r", f"{WHEEL}/brake_pressure:=nowhere",
        wait_for_subscribers=len(LOOP), demand_start=0.0, end_speed=-1.0,
    )  # fmt: skip
    slopes, states, commands = (
        found[f"{WHEEL}/{name}"] for name in ("friction_slope", "abs_supervisor", "brake_command")
    )
    client.until(lambda: len(slopes) > 100 and len(commands) > 100)
    slope = slopes[-1]
    assert not any(message.validity.valid for message in slopes)
    assert slope.validity.reason == Reason.NO_PRESSURE
    assert f"{WHEEL}/brake_pressure" in slope.validity.text
    assert {message.command for message in commands} == {BrakeCommand.NONE}
    assert {message.state for message in states} == {SupervisorState.S0}
    assert not states[-1].validity.valid
    assert states[-1].validity.reason == Reason.NO_PRESSURE
    assert f"{WHEEL}/brake_pressure" in states[-1].validity.text
    assert all(process.poll() is None for process in processes)


@pytest.mark.parametrize("speed", [math.nan, math.inf])
def test_a_wheel_speed_that_is_no_number_is_named_and_survived(client: DdsClient, speed: float) -> None:
    processes = start_estimators(client)
    found = record(client)
    car = Car(client)
    slips, commands = found[f"{WHEEL}/slip"], found[f"{WHEEL}/brake_command"]

    def answered() -> bool:
        return bool(slips) and to_nanoseconds(slips[-1].header.stamp) >= car.stamp - 20 * PERIOD

    car.drive(200)
    client.until(answered)
    assert slips[-1].validity.valid, slips[-1].validity.text
    car.drive(60, wheel_speed=speed)
    client.until(answered)
    assert not slips[-1].validity.valid
    assert slips[-1].validity.reason != Reason.OK
    assert WHEEL in slips[-1].validity.text
    assert math.isnan(slips[-1].slip)
    client.until(lambda: to_nanoseconds(commands[-1].header.stamp) >= car.stamp - 20 * PERIOD)
    assert commands[-1].command == BrakeCommand.NONE
    car.drive(200)
    client.until(lambda: answered() and slips[-1].validity.valid)
    assert all(process.poll() is None for process in processes)
    assert_in_order(found)


def test_stamps_that_repeat_give_no_output_and_leave_the_state_alone(client: DdsClient) -> None:
    processes = start_estimators(client)
    found = record(client)
    car = Car(client)
    slips = found[f"{WHEEL}/slip"]
    car.drive(150)
    car.drive_until_answered(slips)
    car.drive(50, wheel_speed=10.0, pressure=0.0, repeat_stamp=True)
    car.drive(50)
    client.until(lambda: bool(slips) and to_nanoseconds(slips[-1].header.stamp) >= car.stamp - 20 * PERIOD)
    assert_in_order(found)
    assert all(len(received) > 100 for received in found.values())
    speeds = [message.wheel_speed for message in slips if math.isfinite(message.wheel_speed)]
    assert min(speeds[10:]) > 60.0  # the 10 rad/s of the repeated stamps had no effect
    assert all(process.poll() is None for process in processes)


PACE = 0.04
"""Wall time [s] between the samples of PacedInputs: an input may be late by its period, and a busy machine is late."""


class PacedInputs:
    """Inputs of a supervisor that commands, sent by the clock, as sensors do; each of them can stop or repeat."""

    def __init__(self, client: DdsClient) -> None:
        node = client.node
        self._client = client
        kinds = {
            "wheel_states": JointState,
            f"{WHEEL}/brake_pressure": FluidPressure,
            "brake_demand": BrakeDemand,
            f"{WHEEL}/slip": WheelSlip,
            f"{WHEEL}/slope_vote": SlopeVote,
        }
        self.publishers = {topic: qos.publish(node, kind, topic) for topic, kind in kinds.items()}
        self.states: list[SupervisorState] = []
        self.commands: list[BrakeCommand] = []
        qos.subscribe(node, SupervisorState, f"{WHEEL}/abs_supervisor", self.states.append, EVERYTHING)
        qos.subscribe(node, BrakeCommand, f"{WHEEL}/brake_command", self.commands.append, EVERYTHING)
        client.until(lambda: all(publisher.get_subscription_count() > 0 for publisher in self.publishers.values()))
        client.until(lambda: node.count_publishers(f"{WHEEL}/brake_command") == 1)
        self.fault, self.lost = "", ""
        self._sent = 0
        self._frozen = Header()
        self._due = time.monotonic()

    def send(self) -> None:
        """Send the next sample of each input when it is due."""
        while (left := self._due - time.monotonic()) > 0.0:
            self._client.executor.spin_once(timeout_sec=left)
        self._due = max(self._due + PACE, time.monotonic())
        now = Header(stamp=self._client.node.get_clock().now().to_msg())
        for topic, publisher in self.publishers.items():
            if topic != self.lost:
                publisher.publish(self._message(topic, now))
            elif self.fault == "repeats":
                publisher.publish(self._message(topic, self._frozen))
        if not self.lost:
            self._frozen = now

    def _message(self, topic: str, header: Header) -> Any:
        if topic == "wheel_states":
            self._sent += 1
            return JointState(header=header, name=[WHEEL], velocity=[60.0 + 0.01 * (self._sent % 7)])
        if topic == "brake_demand":
            return BrakeDemand(header=header, pressure=4e6)
        if topic.endswith("brake_pressure"):
            return FluidPressure(header=header, fluid_pressure=4e6)
        if topic.endswith("slip"):
            return WheelSlip(
                header=header, slip=0.05, slip_stddev=0.00316, vehicle_speed=19.0, validity=Validity(valid=True)
            )
        return SlopeVote(header=header, h=500.0, indicator=500.0, validity=Validity(valid=True))

    def until(self, condition: Callable[[], bool]) -> None:
        """Send until a condition holds."""

        def holds() -> bool:
            self.send()
            return condition()

        self._client.until(holds)


def test_a_lost_input_brings_none_by_the_clock_with_its_reason_and_abs_comes_back(client: DdsClient) -> None:
    process = start(client, "abs_supervisor", shadow=False)
    inputs = PacedInputs(client)

    def in_force(command: int, reasons: set[int]) -> bool:
        told, commanded = inputs.states, inputs.commands
        return bool(told and commanded) and commanded[-1].command == command and told[-1].validity.reason in reasons

    lost = {
        "wheel_states": Reason.NO_WHEEL_SPEED,
        f"{WHEEL}/brake_pressure": Reason.NO_PRESSURE,
        "brake_demand": Reason.NO_DEMAND,
        f"{WHEEL}/slope_vote": Reason.NO_SLOPE,
    }
    for topic, reason in lost.items():
        for fault in ("silent", "repeats"):
            inputs.until(lambda: in_force(BrakeCommand.INCREASE, {Reason.OK}))
            inputs.fault, inputs.lost = fault, topic
            # Without a slope no state follows that of the fail-safe, which on a busy machine another input may bring.
            reasons = set(lost.values()) if reason == Reason.NO_SLOPE else {reason}
            inputs.until(lambda reasons=reasons: in_force(BrakeCommand.NONE, reasons))  # type: ignore[misc]
            assert topic in inputs.states[-1].validity.text or inputs.states[-1].validity.reason != reason
            # It stays so. The first NONE may be of a sender that a busy machine held up, before the fault is seen.
            inputs.until(lambda: {command.command for command in inputs.commands[-20:]} == {BrakeCommand.NONE})
            inputs.lost = ""
    counters = [command.counter for command in inputs.commands]
    assert all(a < b for a, b in pairwise(counters)), "a client that stalls may miss some, whose lifespan has ended"
    assert process.poll() is None


def test_resetting_the_plant_resets_the_whole_graph(client: DdsClient) -> None:
    start_estimators(client, stale_after=5.0)  # a stall of the machine is no silence in lock-step
    found = record(client)
    start(
        client, "corner_sim", lock_step=True, real_time_factor=0.0, start_stamp=START, wait_for_subscribers=len(LOOP),
        demand_start=0.1, lock_step_timeout=60.0,
    )  # fmt: skip
    commands = found[f"{WHEEL}/brake_command"]
    client.until(lambda: len(commands) > 200)
    assert client.call(Trigger, "/corner_sim/reset", Trigger.Request()).success

    def epochs(received: list[Any]) -> tuple[list[Any], list[Any]]:
        stamps = [to_nanoseconds(message.header.stamp) for message in received]
        jump = stamps.index(START, 1) if START in stamps[1:] else len(stamps)
        return received[:jump], received[jump:]

    client.until(lambda: all(len(epochs(received)[1]) > 150 for received in found.values()))
    for topic, received in found.items():
        before, after = epochs(received)
        assert len(before) > 150
        for k, (first, again) in enumerate(zip(before[:150], after[:150], strict=True)):
            if isinstance(first, SupervisorState):  # its counts and its cause show the reset
                assert (first.state, first.validity.reason) == (again.state, again.validity.reason), k
            elif isinstance(first, BrakeCommand):  # its counter goes on
                assert (first.header, first.command) == (again.header, again.command), k
            else:
                assert encode(first) == encode(again), (topic, k)
    states = epochs(found[f"{WHEEL}/abs_supervisor"])[0]
    assert any(message.state != SupervisorState.S0 for message in states[:150])
