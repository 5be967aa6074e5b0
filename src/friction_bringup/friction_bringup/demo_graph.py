"""The processes of the demo: which are started, when all of them are connected, and whether one has failed."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rclpy.node import Node
from std_srvs.srv import Trigger

from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE
from friction_bags.results.run_reader import has_wheel_states
from friction_bringup import graph
from friction_bringup.demo_drive import CALIBRATION, WAITED_FOR, plant_of_demo
from friction_bringup.discovery import local_discovery
from friction_bringup.node_start import WATCHING, Decided, commanding, composed_arguments, left_to_file, node_starts
from friction_bringup.processes import ProcessGroup
from friction_runtime.domain import free_domain_id
from vehicle_models.vehicle_file import load_vehicle

_RECORDER = "recorder"
_PLAYER = "player"
_LISTENERS = 2
"""Subscribers of wheel_states beside the graph: recorder and live view."""
_LAST_ANSWERS = ("/abs_supervisor", "/friction_curve")
"""The estimates that no other node waits for: when they are there, a sample is done."""
_DISCOVERY_LIMIT = 30.0
"""Wall time [s] the player waits for its subscribers, and again for its publishers, on an idle machine."""


class DemoError(RuntimeError):
    """The demo cannot go on; the text names what failed and its log."""


@dataclass(frozen=True)
class DemoOptions:
    """Options of the command line."""

    surface: str
    law: str
    """Of the supervisor."""
    bag: Path | None
    """Bag to replay in place of the plant."""
    vehicle: str
    """Vehicle file, or name of a shipped one."""
    params_file: Path
    out: Path
    """Directory in which each run gets its own directory."""


class DemoGraph:
    """Recorder, estimators, supervisor and the source of samples, each a process, on a separate domain."""

    def __init__(self, options: DemoOptions, directory: Path) -> None:
        """Check the parameters of the nodes, and choose the domain; nothing is started.

        Args:
            options: options of the command line.
            directory: directory of this run.

        Raises:
            ParameterError: the parameter file or the vehicle file does not exist, or is bad for one of the nodes.
        """
        self._options = options
        self.wheels = load_vehicle(options.vehicle).wheel_names
        """Names of the wheels of the car."""
        nodes = ESTIMATORS if options.bag else (*ESTIMATORS, graph.PLANT)
        self._starts = node_starts(nodes, _decided(options), str(options.params_file), options.vehicle)
        self.notes = tuple(note for start in self._starts for note in start.notes)
        """Notes for the user before the start."""
        self._processes = ProcessGroup(directory / "log")
        self.bag = directory / "bag"
        """The bag that is recorded."""
        self.source = graph.PLANT if options.bag is None else _PLAYER
        """The process whose end is the end of the run."""
        self.environment = {
            "ROS_DOMAIN_ID": str(free_domain_id()),
            **local_discovery(),
            "ROS_LOG_DIR": str(directory / "log"),
            "RCUTILS_COLORIZED_OUTPUT": "0",
            "PYTHONUNBUFFERED": "1",
        }

    def start(self) -> None:
        """Start recorder, estimators, and the plant, which waits for `begin`."""
        record = ["friction_bags", "record", "--out", str(self.bag), "--vehicle", self._options.vehicle]
        self._run(_RECORDER, [sys.executable, "-m", *record])
        estimators = [sys.executable, "-m", "friction_bringup", "graph", "--ros-args"]
        self._run(graph.COMPOSED_PROCESS, [*estimators, *composed_arguments(self._starts)])
        for start in self._starts:
            if start.node not in graph.COMPOSED:
                self._run(start.node, graph.command(start.node, start.files, start.decided))

    def _run(self, name: str, command: list[str]) -> None:
        self._processes.start(name, [*command, *graph.QUIET_LOG], os.environ | self.environment)

    def missing(self, observer: Node) -> list[str]:
        """Return what is not there yet and must be before the first sample, so that no process misses one."""
        replay = self._options.bag is not None
        nodes = set(observer.get_node_names())
        missing = [node for node in (_RECORDER, *(ESTIMATORS if replay else graph.NODES)) if node not in nodes]
        topics = [name for name, _ in observer.get_topic_names_and_types()]
        for suffix in graph.ESTIMATES if replay else (*graph.ESTIMATES, graph.COMMAND):
            named = [topic for topic in topics if topic.endswith(f"/{suffix}") and "/truth/" not in topic]
            estimates = [topic for topic in named if observer.count_publishers(topic)]
            unheard = [topic for topic in estimates if not _hears(observer, _RECORDER, topic)]
            missing += [f"the recorder on {topic}" for topic in (unheard if estimates else [f"WHEEL/{suffix}"])]
        return missing

    def begin(self, observer: Node, wait_for: Callable[[Callable[[], bool]], None]) -> None:
        """Let the first sample come: start the plant's run, or the player.

        The player waits for the recorder and for everything that hears a topic now.

        Args:
            observer: a node of this process.
            wait_for: spins the node until a condition holds, or for as long as a start may take.
        """
        if self._options.bag is None:
            client = observer.create_client(Trigger, f"{graph.PLANT}/start")
            wait_for(client.service_is_ready)  # a request before is lost
            wait_for(client.call_async(Trigger.Request()).done)
            return
        heard = {name: observer.count_subscribers(name) for name, _ in observer.get_topic_names_and_types()}
        last = [name for name in heard if name.endswith(_LAST_ANSWERS) and "/truth/" not in name]
        play = ["friction_bags", "play", str(self._options.bag), "--topics", *graph.INPUTS]
        play += ["--wait", f"{_DISCOVERY_LIMIT:.0f}", "--settle", "1"]
        play += ["--subscribers", "1", *(f"{name}={count + 1}" for name, count in heard.items())]
        with BagReader(self._options.bag) as reader:
            if has_wheel_states(reader):  # without, there is no answer to every stamp
                # In real time, yet never further ahead of an estimator than queues hold: a stall loses nothing.
                play += ["--follow", *last, "--ahead", "30"]
        self._run(_PLAYER, [sys.executable, "-m", *play])

    @property
    def ended(self) -> bool:
        """Whether any process has ended."""
        return bool(self._processes.ended())

    @property
    def done(self) -> bool:
        """Whether the source of samples has ended without an error.

        Raises:
            DemoError: another process has ended, or one has failed.
        """
        ended = self._processes.ended()
        for name, code in ended.items():
            if name != self.source or code != 0:
                log = self._processes.log(name)
                tail = "\n".join(log.read_text(errors="replace").splitlines()[-15:])
                raise DemoError(f"{name} ended with exit code {code}; the end of {log}:\n{tail}")
        return self.source in ended

    def stop(self, grace: float) -> list[str]:
        """End every process; return the names of those that took longer than `grace` [s] and were killed."""
        return self._processes.stop(grace)


def _decided(options: DemoOptions) -> Decided:
    """Return the parameters of the demo that override the parameter files, by node.

    Raises:
        ParameterError: the parameter file or the vehicle file does not exist, or is bad.
    """
    if options.bag:
        return WATCHING
    of_demo = plant_of_demo(options.surface, options.vehicle)
    waited_for = graph.wheel_states_subscriptions(composed=True) + _LISTENERS
    plant = {**of_demo[graph.PLANT], "exit_when_done": True, "autostart": False, WAITED_FOR: waited_for}
    decided: Decided = {**commanding(options.law), **of_demo, graph.PLANT: plant}
    decided = left_to_file(decided, graph.PLANT, WAITED_FOR, str(options.params_file))
    return left_to_file(decided, SMART_TYRE, CALIBRATION, str(options.params_file))


def _hears(observer: Node, name: str, topic: str) -> bool:
    return any(info.node_name == name for info in observer.get_subscriptions_info_by_topic(topic))
