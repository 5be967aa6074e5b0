"""brake_command as its consumer sees it when the supervisor is killed, stopped or restarted."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import sqrt
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from friction_msgs.msg import BrakeCommand, BrakeDemand
from rclpy.qos import LivelinessPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import FluidPressure, JointState

from campaigns.live.part import LOOP
from friction_bringup import graph
from friction_runtime import qos
from friction_runtime.installed import shipped_file
from friction_runtime.messages import to_nanoseconds
from friction_test_support.dds_client import DdsClient, dds_client
from friction_test_support.machine_load import slowdown
from vehicle_models.nanoseconds import NANOSECONDS

WHEEL = "front_left"
EVERYTHING = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
HYDRAULICS = 0.5
"""Message time [s] in which the brake line comes from nothing to the driver's pressure, generously."""
LIFESPAN = 0.1
"""Of a command in real time [s]: the default of abs_supervisor."""
SCRIPTED = Path(__file__).with_name("scripted_supervisor.py")
LONG_AGO = 1_000_000
"""Commands of a supervisor that was started long ago: more than any is ahead before all have found it."""
SPEED = 150.0
"""[m/s]. From there a stop on snow takes longer than the test."""
SLOWEST = 2.2
"""[m/s^2]. No car brakes harder on snow: a wheel that stays locked without supervisor is long known to be no stop."""


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client() as made:
        yield made


class Loop:
    """The plant in real time in an endless panic stop on snow, a supervisor, and what both publish."""

    def __init__(self, client: DdsClient, scripted: bool) -> None:
        self._client = client
        self.commands: list[BrakeCommand] = []
        self.pressures: list[FluidPressure] = []
        self._demands: list[BrakeDemand] = []
        self._health: list[DiagnosticArray] = []
        for topic, kind, received in (
            (f"{WHEEL}/brake_command", BrakeCommand, self.commands),
            (f"{WHEEL}/brake_pressure", FluidPressure, self.pressures),
            ("brake_demand", BrakeDemand, self._demands),
            ("/diagnostics", DiagnosticArray, self._health),
        ):
            qos.subscribe(client.node, kind, topic, received.append, EVERYTHING)
        if not scripted:
            self._start("wheel_slip")
            self._start("friction_slope", **{"detector.max_deceleration": SLOWEST})
        self.start_supervisor(scripted)
        self._start(
            graph.PLANT,
            surfaces=["snow"],
            initial_speed=SPEED,
            demand_start=1.0,
            end_speed=-1.0,
            wait_for_subscribers=1 if scripted else len(LOOP),
        )

    def start_supervisor(self, scripted: bool, counted: int = LONG_AGO) -> None:
        """Start one; a scripted one has commanded `counted` times before."""
        if scripted:
            self.supervisor = self._client.start(str(SCRIPTED), str(counted))
        else:
            self.supervisor = self._start(graph.SUPERVISOR, shadow=False)

    def _start(self, node: str, **parameters: graph.ParameterValue) -> subprocess.Popen[str]:
        command = graph.command(node, [shipped_file(node)], {"vehicle_file": "chapter_corner", **parameters})
        return self._client.start(*command[1:])

    @property
    def now(self) -> int:
        """Newest stamp of the plant [ns]."""
        return stamp_of(self.pressures[-1])

    @property
    def driver(self) -> float:
        """Pressure that the driver demands [Pa], 0 before the first message."""
        return self._demands[-1].pressure if self._demands else 0.0

    def until_obeyed(self) -> None:
        """Wait for a release that the plant obeys, from now on: of a brake that is applied."""
        self._client.until(lambda: bool(self.pressures) and self.pressures[-1].fluid_pressure > 0.9 * self.driver > 0.0)
        commands, pressures = len(self.commands), len(self.pressures)

        def released() -> bool:
            releases = [each for each in self.commands[commands:] if each.command == BrakeCommand.DECREASE]
            return bool(releases) and any(
                stamp_of(each) > stamp_of(releases[0]) and each.fluid_pressure < 0.7 * self.driver
                for each in self.pressures[pressures:]
            )

        self._client.until(released)

    def until_driver_brakes(self) -> int:
        """Wait until the plant has long been at the driver's pressure; return from which stamp on it must be [ns]."""
        self._client.until(lambda: self.now > stamp_of(self.commands[-1]) + 3 * NANOSECONDS)
        newest = self.commands[-1]
        return stamp_of(newest) + round((newest.valid_for + HYDRAULICS) * NANOSECONDS)

    def assert_driver_brakes(self, begin: int, end: int) -> None:
        """At every stamp from `begin` to `end` [ns] the pressure is what the driver demands."""
        between = [message for message in self.pressures if begin <= stamp_of(message) <= end]
        assert len(between) > 100
        for message in between:
            assert message.fluid_pressure == pytest.approx(self.driver, abs=6.0 * sqrt(message.variance))

    @property
    def heard(self) -> int:
        """Messages of diagnostics so far."""
        return len(self._health)

    def until_plant_says(self, *texts: str, since: int) -> None:
        """Wait for a status of the plant with these texts, among the messages of diagnostics from a number on."""

        def said() -> bool:
            found = [status for array in self._health[since:] for status in array.status]
            return any(
                status.name == "/corner_sim: plant" and all(text in status.message for text in texts)
                for status in found
            )

        self._client.until(said)

    def plant_value(self, key: str) -> str:
        """Newest value in the plant's diagnostics."""
        plants = [s for array in self._health for s in array.status if s.name == "/corner_sim: plant"]
        return {value.key: value.value for value in plants[-1].values}[key]


def stamp_of(message: Any) -> int:
    return to_nanoseconds(message.header.stamp)


def counters(commands: Sequence[BrakeCommand]) -> list[int]:
    return [message.counter for message in commands]


def test_commands_are_offered_with_deadline_lifespan_and_liveliness(client: DdsClient) -> None:
    loop = Loop(client, scripted=False)
    client.until(lambda: bool(loop.commands))
    (offered,) = [info.qos_profile for info in client.node.get_publishers_info_by_topic(f"{WHEEL}/brake_command")]
    assert offered.reliability == ReliabilityPolicy.RELIABLE
    assert offered.deadline.nanoseconds == qos.COMMAND_DEADLINE * NANOSECONDS
    assert 0 < offered.lifespan.nanoseconds <= loop.commands[-1].valid_for * NANOSECONDS
    assert offered.liveliness == LivelinessPolicy.AUTOMATIC
    assert offered.liveliness_lease_duration.nanoseconds == qos.COMMAND_LEASE * NANOSECONDS


def test_after_a_killed_supervisor_the_driver_brakes_and_a_new_one_is_obeyed(client: DdsClient) -> None:
    loop = Loop(client, scripted=True)
    loop.until_obeyed()
    since = loop.heard
    loop.supervisor.send_signal(signal.SIGKILL)
    begin = loop.until_driver_brakes()
    loop.assert_driver_brakes(begin, loop.now)
    loop.until_plant_says(f"silent, taken as NONE: {WHEEL}", f"{WHEEL}/brake_command: its supervisor", since=since)
    before = len(loop.commands)
    loop.start_supervisor(scripted=True, counted=0)
    loop.until_obeyed()
    assert counters(loop.commands[before:])[0] < counters(loop.commands[:before])[-1]
    client.until(lambda: loop.plant_value("new senders of commands") == "1")


def test_after_a_stopped_supervisor_the_driver_brakes_and_nothing_old_is_obeyed_when_it_goes_on(
    client: DdsClient,
) -> None:
    loop = Loop(client, scripted=True)
    loop.until_obeyed()
    since = loop.heard
    loop.supervisor.send_signal(signal.SIGSTOP)
    begin = loop.until_driver_brakes()
    # On a slow machine the middleware has given it up by now, and the plant says that it has left.
    loop.until_plant_says(f"silent, taken as NONE: {WHEEL}", "no sign of life", since=since)
    before = len(loop.commands)
    woken_at = loop.now
    loop.supervisor.send_signal(signal.SIGCONT)
    loop.until_obeyed()
    # Whatever it answers first, the plant obeys nothing that answers a sample older than the command is valid.
    obeyed = [stamp_of(each) for each in loop.commands[before:]]
    fresh = next(stamp for stamp in obeyed if stamp > woken_at - loop.commands[-1].valid_for * NANOSECONDS)
    loop.assert_driver_brakes(begin, fresh)
    assert loop.plant_value("new senders of commands") == "0"


def test_a_supervisor_that_was_stopped_commands_nothing_for_what_is_old_when_it_goes_on(client: DdsClient) -> None:
    loop = Loop(client, scripted=False)
    client.until(lambda: len(loop.commands) > 200)
    loop.supervisor.send_signal(signal.SIGSTOP)
    loop.until_driver_brakes()
    before = len(loop.commands)
    woken_at = loop.now
    loop.supervisor.send_signal(signal.SIGCONT)
    client.until(lambda: stamp_of(loop.commands[-1]) > woken_at)
    said = loop.commands[before:]
    # A busy machine holds up a supervisor between its look at the clock and the command, whether it was stopped or not.
    old = [each for each in said if stamp_of(each) < woken_at - LIFESPAN * slowdown() * NANOSECONDS]
    assert {each.command for each in old} <= {BrakeCommand.NONE}
    assert all(a < b for a, b in pairwise(counters(loop.commands)))


def test_in_lock_step_no_stall_of_the_plant_costs_it_a_command(client: DdsClient) -> None:
    def start(node: str, **parameters: graph.ParameterValue) -> subprocess.Popen[str]:
        command = graph.command(node, [shipped_file(node)], {"vehicle_file": "chapter_corner", **parameters})
        return client.start(*command[1:])

    start("wheel_slip")
    start("friction_slope")
    start(graph.SUPERVISOR, shadow=False, real_time=False, stale_after=60.0)
    samples: list[JointState] = []
    qos.subscribe(client.node, JointState, "wheel_states", samples.append, EVERYTHING)
    plant = start(
        graph.PLANT,
        lock_step=True,
        end_time=3.0,
        exit_when_done=True,
        wait_for_subscribers=len(LOOP) + 1,
        lock_step_timeout=60.0,
    )
    for reached in (50, 150, 250, 350, 450):
        client.until(lambda reached=reached: len(samples) > reached)  # type: ignore[misc]
        plant.send_signal(signal.SIGSTOP)
        time.sleep(3.0 * LIFESPAN)  # what is under way to the plant grows older than any command may in real time
        plant.send_signal(signal.SIGCONT)
    client.until(lambda: plant.poll() is not None)
    assert plant.returncode == 0
    assert [stamp_of(each) - stamp_of(samples[0]) for each in samples] == [k * 5_000_000 for k in range(601)]
