"""Fail-safe times over DDS with real processes: from the last good message of an input to the NONE that answers it.

Both times are those of publication, by the wall clock of one machine. The largest contains the stalls of the machine.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf, nan
from pathlib import Path

import numpy as np
import rclpy
from friction_msgs.msg import BrakeCommand, SlopeVote
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from benchmarks.protocol import CAR, VEHICLE, WHEEL
from benchmarks.rows import Row, at_most
from campaigns.faults import stamps, wheel_sensor
from campaigns.faults.catalogue import FAIL_SAFE
from campaigns.faults.fault import Fault, Site, at_once
from campaigns.faults.live_car import LiveCar
from campaigns.faults.manoeuvre import ONSET
from campaigns.faults.signals import constant, frozen, silent
from friction_bags.offline.estimators import WHEEL_ESTIMATORS
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_runtime import qos
from friction_runtime.domain import free_domain_id
from friction_runtime.wheel_speeds import WHEEL_STATES

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
    ("wheel_states NaN", WHEEL_STATES, wheel_sensor.not_a_number),
    ("wheel_states crawling stamps", WHEEL_STATES, lambda site: stamps.crawling([WHEEL_STATES])),
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
        self._env = os.environ | {"ROS_DOMAIN_ID": str(domain), "OMP_NUM_THREADS": "1"}
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
