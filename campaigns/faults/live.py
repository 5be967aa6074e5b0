"""Fail-safe of the live graph: a simulated car in real time over DDS, a fault in between, the commands that return."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from friction_msgs.msg import BrakeCommand, SlopeVote
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher

from benchmarks.protocol import ACCELERATION_STDDEV, CAR, VEHICLE, WHEEL
from benchmarks.runner import Row, at_most
from campaigns.faults import sensors, transport
from campaigns.faults.case import ONSET, Fault, Site, at_once, constant, frozen, silent
from campaigns.faults.catalogue import FAIL_SAFE
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS
from corner_sim.ros.messages import topics
from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import WHEEL_ESTIMATORS
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_runtime import qos
from friction_runtime.domain import free_domain_id
from friction_runtime.messages import header_at, to_nanoseconds
from friction_runtime.processor import Output
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_models.nanoseconds import NANOSECOND

_PARAMETERS = SimParameters(
    surfaces=("dry",),
    demand_level=0.1,
    initial_speed=60.0,
    acceleration_variance=ACCELERATION_STDDEV**2,
    end_time=25.0,
)
"""A gentle stop of one corner, so that many trials go into one; it ends far from standstill."""


class LiveCar:
    """Publishes a sample every 5 ms of the steady clock, and notes when each message and each command was sent.

    The samples are made beforehand, so that a busy machine can keep up. One that is missed all the same is left out, as
    it would be by a sensor; then stamps still go with the clock. At the end of its stop the car rolls at 60 m/s again.
    """

    def __init__(self, node: Node, executor: SingleThreadedExecutor) -> None:
        """Connect; nothing is published yet."""
        self.fault: Fault = at_once
        self.command = int(BrakeCommand.NONE)
        """The newest one."""
        self.answered = -inf
        """Stamp [s] of the sample that the newest command answers, unless it is NONE; -inf for NONE."""
        self.commanded_at = -inf
        """Wall clock [s] when the newest command was sent."""
        self.none_since = inf
        """Wall clock [s] when the newest run of NONE began to be sent; inf while another command is in force."""
        self.sent: dict[str, float] = {}
        """Wall clock [s] of the newest message of each topic that came through as it was made."""
        self._executor = executor
        self._publishers: dict[str, Publisher] = {
            topic: qos.publish(node, kind, topic)
            for topic, kind in topics([WHEEL], True, True, False).items()
            if not topic.startswith("truth/")
        }
        self._subscription = node.create_subscription(BrakeCommand, f"{WHEEL}/brake_command", self._take, qos.ESTIMATE)
        simulation = Simulation(_PARAMETERS, CAR, 1)
        self._samples: list[list[Output]] = []
        while simulation.end is None:
            self._samples.append([each for each in simulation.messages() if each[0] in self._publishers])
            simulation.advance()
        self._start = time.time_ns(), time.monotonic()
        self._count = 0

    @property
    def connected(self) -> bool:
        """Every sensor has a reader, and somebody commands."""
        readers = all(publisher.get_subscription_count() for publisher in self._publishers.values())
        return readers and self._subscription.get_publisher_count() > 0

    @property
    def left(self) -> float:
        """Time until the car rolls at 60 m/s again [s], which no wheel can do at once."""
        return (len(self._samples) - self._count % len(self._samples)) * SAMPLE_TIME

    def drive_until(self, condition: Callable[[], bool], limit: float) -> bool:
        """Drive on until a condition holds; return whether it did within a limit [s, wall clock]."""
        until = time.monotonic() + limit
        while not condition():
            if time.monotonic() > until:
                return False
            self._publish(self._count)
            self._count = max(self._count + 1, int((time.monotonic() - self._start[1]) / SAMPLE_TIME))
            due = self._start[1] + self._count * SAMPLE_TIME
            while (left := due - time.monotonic()) > 0.0:
                self._executor.spin_once(timeout_sec=left)
            self._executor.spin_once(timeout_sec=0.0)
        return True

    def _publish(self, count: int) -> None:
        stamp = self._start[0] + count * SAMPLE_TIME_NS
        for topic, made in self._samples[count % len(self._samples)]:
            made.header = header_at(stamp, made.header.frame_id)
            for arrival in self.fault(topic, made if self.fault is at_once else deepcopy(made)):
                self._publishers[topic].publish(arrival.message)
                if arrival.message is made or arrival.message == made:
                    self.sent[topic] = time.time()

    def _take(self, message: BrakeCommand, info: dict[str, Any]) -> None:
        self.command = int(message.command)
        self.commanded_at = info["source_timestamp"] * 1e-9
        if self.command != BrakeCommand.NONE:
            self.none_since = inf
            self.answered = to_nanoseconds(message.header.stamp) * NANOSECOND
        else:
            self.none_since = min(self.none_since, self.commanded_at)
            self.answered = -inf


_VOTE = f"{WHEEL}/slope_vote"
_PRESSURE, _DEMAND = f"{WHEEL}/brake_pressure", "brake_demand"
_START_LIMIT = 60.0
_ANSWER_LIMIT = 2.0
"""[s] A trial without NONE is given up: its time counts as infinite."""
_STOPPED = 1.0
"""[s] for which the supervisor is stopped."""
_STOPPED_TRIAL = 8.0
"""[s] in which such a trial is done, its way to a braking included."""
_BACK = 0.2
"""[s] after which a supervisor that goes on must act again."""
_STEADY = 0.3
"""[s] of commands other than NONE before a trial."""
_INPUTS: tuple[tuple[str, str, Callable[[Site], Fault]], ...] = (
    ("wheel_states silent", WHEEL_STATES, lambda site: silent([WHEEL_STATES])),
    ("wheel_states frozen", WHEEL_STATES, lambda site: frozen([WHEEL_STATES])),
    ("wheel_states NaN", WHEEL_STATES, sensors.not_a_number),
    ("wheel_states crawling stamps", WHEEL_STATES, lambda site: transport.crawling([WHEEL_STATES])),
    ("brake_pressure silent", _PRESSURE, lambda site: silent([_PRESSURE])),
    ("brake_pressure frozen", _PRESSURE, lambda site: frozen([_PRESSURE])),
    ("brake_pressure NaN", _PRESSURE, lambda site: constant([_PRESSURE], "fluid_pressure", nan)),
    ("brake_demand silent", _DEMAND, lambda site: silent([_DEMAND])),
    ("brake_demand frozen", _DEMAND, lambda site: frozen([_DEMAND])),
    ("brake_demand NaN", _DEMAND, lambda site: constant([_DEMAND], "pressure", nan)),
)


class LiveTrials:
    """The four nodes as processes, and a car that brakes."""

    def __init__(self, processes: ProcessGroup, domain: int, node: Node, executor: SingleThreadedExecutor) -> None:
        """Start the nodes."""
        self._processes = processes
        self._env = os.environ | {"ROS_DOMAIN_ID": str(domain)}
        self._vote_sent = nan
        node.create_subscription(SlopeVote, _VOTE, self._note_vote, qos.ESTIMATE)
        self._car = LiveCar(node, executor)
        for name in WHEEL_ESTIMATORS:
            self._start(name)

    def of_input(self, topic: str, make: Callable[[Site], Fault], seed: int) -> float:
        """Return the time [s] from the last good message of an input to NONE."""
        self._brake()
        self._car.fault = make(Site(CAR, np.random.default_rng(seed)))
        try:
            return self._none_after(lambda: self._car.sent[topic])
        finally:
            self._car.fault = at_once

    def of_stopped_slope(self, _: int) -> float:
        """Return the time [s] from the last answer of friction_slope, which is stopped, to NONE."""
        self._brake()
        self._processes.send("friction_slope", signal.SIGSTOP)
        try:
            return self._none_after(lambda: self._vote_sent)
        finally:
            self._processes.send("friction_slope", signal.SIGCONT)

    def of_killed_slope(self, _: int) -> float:
        """Return the time [s] from the last answer of friction_slope, which is killed, to NONE."""
        self._brake()
        self._processes.send("friction_slope", signal.SIGKILL)
        try:
            return self._none_after(lambda: self._vote_sent)
        finally:
            self._start("friction_slope")

    def of_stopped_supervisor(self, _: int) -> float:
        """Return the time [s] from SIGCONT to the first command other than NONE that answers a sample of after it."""
        self._car.drive_until(lambda: self._car.left > _STOPPED_TRIAL, _START_LIMIT)
        self._brake()
        self._processes.send(graph.SUPERVISOR, signal.SIGSTOP)
        stopped = time.monotonic()
        self._car.drive_until(lambda: time.monotonic() - stopped > _STOPPED, _ANSWER_LIMIT)
        self._processes.send(graph.SUPERVISOR, signal.SIGCONT)
        woken = time.time()
        found = self._car.drive_until(lambda: self._car.answered > woken, _ANSWER_LIMIT)
        return self._car.commanded_at - woken if found else inf

    def _none_after(self, good: Callable[[], float]) -> float:
        """Drive until NONE; `good` tells when the last good message was sent [s, wall clock]."""
        car = self._car
        found = car.drive_until(lambda: car.none_since < inf, _ANSWER_LIMIT)
        return car.none_since - good() if found else inf

    def _brake(self) -> None:
        """Drive until the supervisor has been acting for a while."""
        car = self._car
        if not car.drive_until(lambda: car.connected and car.command != BrakeCommand.NONE, _START_LIMIT):
            raise RuntimeError(f"the supervisor does not act within {_START_LIMIT} s")
        since = [time.monotonic()]

        def steady() -> bool:
            if car.command == BrakeCommand.NONE:
                since[0] = time.monotonic()
            return time.monotonic() - since[0] > _STEADY

        if not car.drive_until(steady, _START_LIMIT + ONSET):
            raise RuntimeError(f"the supervisor does not go on acting within {_START_LIMIT} s")

    def _start(self, name: str) -> None:
        overrides: dict[str, graph.ParameterValue] = {"vehicle_file": VEHICLE}
        if name == graph.SUPERVISOR:
            overrides["shadow"] = False
        command = graph.command(name, graph.parameter_files(name, None), overrides)
        self._processes.start(name, command, self._env)

    def _note_vote(self, _: SlopeVote, info: dict[str, int]) -> None:
        self._vote_sent = info["source_timestamp"] * 1e-9


def fail_safe_rows(trials: int, done: Callable[[], None]) -> list[Row]:
    """Return a row per input and kind of loss; `done` is called after each trial.

    Raises:
        RuntimeError: the graph does not start.
    """
    rows: list[Row] = []
    with _live_trials() as live:
        kinds: list[tuple[str, Callable[[int], float], float]] = [
            (name, lambda seed, topic=topic, make=make: live.of_input(topic, make, seed), FAIL_SAFE)  # type: ignore[misc]
            for name, topic, make in _INPUTS
        ]
        kinds += [
            ("friction_slope stopped", live.of_stopped_slope, FAIL_SAFE),
            ("friction_slope killed", live.of_killed_slope, FAIL_SAFE),
            ("abs_supervisor stopped: back after", live.of_stopped_supervisor, _BACK),
        ]
        for name, trial, limit in kinds:
            times: list[float] = []
            while len(times) < trials:
                found = trial(len(times))
                if found > 0.0:  # else a stall of the machine has brought NONE before the loss could
                    times.append(found)
                    done()
            rows.append(fail_safe_row(name, times, limit))
    return rows


LIVE_ROWS = len(_INPUTS) + 3
"""Kinds of loss."""


def fail_safe_row(name: str, times: list[float], limit: float) -> Row:
    """Row of one kind of loss; the value is the largest of its times [s]."""
    return {
        "car": "corner, live",
        "fault": name,
        "trials": len(times),
        **at_most(max(times), limit),
        "median_ms": 1e3 * float(np.median(times)),
        "max_ms": 1e3 * max(times),
    }


@contextmanager
def _live_trials() -> Iterator[LiveTrials]:
    os.environ.update(local_discovery())
    domain = free_domain_id()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    with tempfile.TemporaryDirectory(prefix="friction_faults_") as logs:
        processes = ProcessGroup(Path(logs))
        try:
            node = rclpy.create_node("live_car", context=context)
            executor = SingleThreadedExecutor(context=context)
            executor.add_node(node)
            yield LiveTrials(processes, domain, node, executor)
        finally:
            processes.stop()
            rclpy.try_shutdown(context=context)
