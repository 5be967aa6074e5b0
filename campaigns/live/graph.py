"""The nodes as processes on a DDS domain of their own with an observer, and the same loop offline."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from campaigns.dds import arrived, tap
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.cdr import encode
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_runtime.domain import free_domain_id
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Processor, ProcessorGraph
from friction_test_support.machine_load import slowdown

Overrides = Mapping[str, Mapping[str, graph.ParameterValue]]
_TAKE_PERIOD = 0.02
_START_LIMIT = 60.0
_SETTLE = 2.0
"""Wall time [s] before the start in which the other nodes find each other."""
_QUIET = 1.0
"""Wall time [s] after the end of the plant in which the last messages arrive."""


class LiveRunError(RuntimeError):
    """A process of the graph failed; the text holds the end of its log."""


@dataclass
class Observation:
    """Messages of one topic, in order of arrival."""

    messages: list[Any] = field(default_factory=list)
    published: list[int] = field(default_factory=list)
    """Wall clock of publication [ns]."""

    @property
    def stamps(self) -> list[int]:
        """Message stamps [ns]."""
        return [to_nanoseconds(message.header.stamp) for message in self.messages]

    def take(self, subscription: Subscription) -> None:
        """Take all messages that have arrived."""
        for message, published in arrived(subscription):
            self.messages.append(message)
            self.published.append(published)


def run_graph(
    estimators: Sequence[str],
    topics: Mapping[str, type],
    overrides: Overrides,
    timeout: float,
    progress: Callable[[int], None],
) -> dict[str, Observation]:
    """Run the plant and some nodes with their shipped parameter files until the plant ends its run.

    Args:
        estimators: the nodes beside the plant.
        topics: what to observe, with types; "wheel_states" among them.
        overrides: parameters that decide over the shipped files, by node.
        timeout: longest wall time of the run [s].
        progress: called with the number of samples seen.

    Raises:
        LiveRunError: a process failed, or the run took too long.
    """
    os.environ.update(local_discovery())
    domain = free_domain_id()
    env = os.environ | {"ROS_DOMAIN_ID": str(domain)}
    with tempfile.TemporaryDirectory(prefix="friction_live_") as logs:
        processes = ProcessGroup(Path(logs))
        try:
            for node in (*estimators, graph.PLANT):
                shipped = graph.parameter_files(node, None)
                chosen = dict(overrides.get(node, {}))
                if node == graph.PLANT:
                    # wheel_states goes to each estimator and to this process
                    chosen.update(autostart=False, exit_when_done=True, wait_for_subscribers=len(estimators) + 1)
                processes.start(node, graph.command(node, shipped, chosen), env)
            return _observe(topics, domain, processes, timeout, progress)
        finally:
            processes.stop()


def _observe(
    topics: Mapping[str, type],
    domain: int,
    processes: ProcessGroup,
    timeout: float,
    progress: Callable[[int], None],
) -> dict[str, Observation]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    try:
        node = rclpy.create_node("live_observer", context=context)
        taps = {topic: tap(node, kind, topic) for topic, kind in topics.items()}
        found = {topic: Observation() for topic in topics}
        deadline = time.monotonic() + timeout

        def take_until(condition: Callable[[], bool]) -> None:
            while not condition():
                time.sleep(_TAKE_PERIOD)
                for topic, subscription in taps.items():
                    found[topic].take(subscription)
                _check(processes, deadline)
                progress(len(found["wheel_states"].messages))

        def take_for(seconds: float) -> None:
            until = time.monotonic() + seconds
            take_until(lambda: time.monotonic() > until)

        take_until(lambda: all(each.get_publisher_count() for each in taps.values()))
        take_for(_SETTLE * slowdown())
        _start(context)
        take_until(lambda: graph.PLANT in processes.ended())
        take_for(_QUIET * slowdown())
        node.destroy_node()
        return found
    finally:
        rclpy.try_shutdown(context=context)


def _start(context: rclpy.Context) -> None:
    """Call the plant's ~/start and wait for its answer."""
    node = rclpy.create_node("live_starter", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    client = node.create_client(Trigger, f"/{graph.PLANT}/start")
    if not client.wait_for_service(_START_LIMIT):
        raise LiveRunError(f"no service /{graph.PLANT}/start within {_START_LIMIT} s")
    executor.spin_until_future_complete(client.call_async(Trigger.Request()), _START_LIMIT)
    node.destroy_node()


def _check(processes: ProcessGroup, deadline: float) -> None:
    for name, code in processes.ended().items():
        if code != 0 or name != graph.PLANT:
            text = "\n".join(processes.log(name).read_text(errors="replace").splitlines()[-15:])
            raise LiveRunError(f"{name} ended with code {code}:\n{text}")
    if time.monotonic() > deadline:
        raise LiveRunError("the plant did not come to the end of its run in time")


def run_offline(simulation: Simulation, processors: Sequence[Processor]) -> dict[str, list[bytes]]:
    """Run the simulation to its end with the processors in the loop.

    Args:
        simulation: the plant, at its first sample.
        processors: all that take part, in any order.

    Returns:
        Every message of the run, encoded, by topic, in order.

    Raises:
        RuntimeError: a sample stays without brake_command: the loop is not closed.
    """
    graph = ProcessorGraph(processors)
    found: dict[str, list[bytes]] = {}
    while True:
        for topic, message in simulation.messages():
            for name, each in ((topic, message), *graph.feed(topic, message)):
                found.setdefault(name, []).append(encode(each))
                if name.endswith("/brake_command"):
                    simulation.take_command(each.wheel, each)
        if simulation.end is not None:
            return found
        if simulation.unanswered:
            raise RuntimeError(
                f"no brake_command at stamp {simulation.stamp} ns for {', '.join(simulation.unanswered)}"
            )
        simulation.advance()
