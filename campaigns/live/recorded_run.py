"""A recording of the sensors of cars, replayed to the estimators live: cost, delays and losses."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import rclpy
from friction_msgs.msg import BrakeCommand, FrictionCurve, FrictionSlope, WheelSlip
from numpy.typing import NDArray
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from campaigns.dds import arrived, tap
from campaigns.live.graph import LiveRunError
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.record_replay.flow_control import header_stamp
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_parameters.parameter import from_mapping
from friction_runtime.domain import free_domain_id
from friction_runtime.processor import Output
from friction_test_support.machine_load import slowdown
from vehicle_models.vehicle_file import load_vehicle

SEPARATE, SEPARATE_RELAYS = "separate", "separate relays"
FORMS = (SEPARATE, "composed", "relays")
"""The estimators as a process each, in one process, and in one process without what they compute."""
SOURCE = "wheel_states"
ESTIMATES: Mapping[str, type] = {"slip": WheelSlip, "friction_slope": FrictionSlope, "friction_curve": FrictionCurve}
"""Answers of a wheel to every sample."""
_RELAY = "campaigns.live.relay"
PLAYER = "player"
"""Name of the process that plays the bag."""
_TAKE_PERIOD = 0.02
_START_LIMIT = 60.0
_QUIET = 1.0
"""Wall time [s] after the last sample in which the last messages arrive."""
_START_STAMP = 1_000_000_000
_BRAKING = 5.0
"""The last seconds of a recording are a panic stop [s]."""


@dataclass(frozen=True)
class Drive:
    """Cars that cruise and then brake."""

    vehicle: str
    namespaces: tuple[str, ...]
    """A car in each."""
    model: str
    tyres: bool
    """Whether they have smart tyres."""

    @property
    def wheels(self) -> list[str]:
        """Names of all wheels below the root."""
        return [f"{place}/{wheel}" for place in self.namespaces for wheel in load_vehicle(self.vehicle).wheel_names]


def record(drive: Drive, seconds: float, bag: Path) -> None:
    """Write the sensors of a drive of `seconds` [s] to a bag, at 200 Hz, from a fixed seed."""
    values = {
        "model": drive.model,
        "vehicle_file": drive.vehicle,
        "tyre_signals": drive.tyres,
        "demand_start": max(seconds - _BRAKING, 0.5),
        "initial_speed": 27.0,
    }
    plant = Simulation(from_mapping(SimParameters, values), load_vehicle(drive.vehicle), _START_STAMP)

    def messages() -> Iterator[Output]:
        while plant.time <= seconds:
            for topic, message in plant.messages(truth=False):
                for place in drive.namespaces:
                    yield f"{place}/{topic}", message
            plant.advance()

    write_bag(bag, messages(), {"vehicle": drive.vehicle})


@dataclass
class Answers:
    """Messages of one topic: when each stamp was first published."""

    published: dict[int, int] = field(default_factory=dict)
    """Wall clock [ns] by stamp [ns]."""

    def take(self, subscription: Subscription) -> None:
        """Take all messages that have arrived, without decoding them: less work."""
        for encoded, published in arrived(subscription, raw=True):
            self.published.setdefault(header_stamp(encoded), published)

    def delays(self, sent: Answers) -> NDArray[np.float64]:
        """Delays behind the samples that were sent [ms]."""
        return np.array([at - sent.published[s] for s, at in self.published.items() if s in sent.published]) * 1e-6


@dataclass(frozen=True)
class Measured:
    """One run."""

    processor: Mapping[str, float]
    """Share of a core that each process took [-]."""
    answers: Mapping[str, Answers]
    """By topic."""


def commands(drive: Drive, form: str, supervisor: bool) -> dict[str, list[str]]:
    """Return the command lines of the processes of a form, by name."""
    found: dict[str, list[str]] = {}
    for place in drive.namespaces:
        car = ["--ros-args", "-r", f"__ns:=/{place.strip('/')}", "-p", f"vehicle_file:={drive.vehicle}"]
        modules = {
            SEPARATE: [[name] for name in graph.COMPOSED],
            SEPARATE_RELAYS: [[_RELAY, name] for name in graph.COMPOSED],
            "composed": [["friction_bringup", "graph"]],
            "relays": [[_RELAY]],
        }[form]
        for module in modules:
            found[f"{place.strip('/')}{module[-1]}"] = [sys.executable, "-m", *module, *car]
        if supervisor:
            # Nothing obeys: the recording goes on as it was made.
            module = [_RELAY, graph.SUPERVISOR] if form == SEPARATE_RELAYS else [graph.SUPERVISOR]
            found[graph.SUPERVISOR] = [sys.executable, "-m", *module, *car, "-p", "shadow:=false"]
    return found


def run(
    drive: Drive, bag: Path, form: str, rate: float, seconds: float, supervisor: bool, progress: Callable[[int], None]
) -> Measured:
    """Replay a recording to the estimators.

    Args:
        drive: what was recorded.
        bag: the recording.
        form: one of FORMS, or SEPARATE_RELAYS.
        rate: samples in a second of wall time [Hz].
        seconds: how much of the recording is replayed [s of the recording].
        supervisor: whether abs_supervisor answers too, a process of its own.
        progress: called with the number of samples seen.

    Raises:
        LiveRunError: a process failed, or the run took too long.
    """
    os.environ.update(local_discovery())
    env = os.environ | {"ROS_DOMAIN_ID": str(free_domain_id())}
    # Every reader costs the publisher: estimates are observed at one wheel of a car, commands at all of them.
    observed = drive.wheels[:: len(drive.wheels) // len(drive.namespaces)]
    taps = {f"{place}/{SOURCE}": JointState for place in drive.namespaces}
    taps |= {f"{wheel}/{name}": kind for wheel in observed for name, kind in ESTIMATES.items()}
    taps |= {f"{wheel}/{graph.COMMAND}": BrakeCommand for wheel in drive.wheels if supervisor}
    with tempfile.TemporaryDirectory(prefix="friction_live_") as logs:
        processes = ProcessGroup(Path(logs))
        try:
            for name, command in commands(drive, form, supervisor).items():
                processes.start(name, command, env)
            play = ["friction_bags", "play", str(bag), "--rate", str(rate / 200.0), "--duration", str(seconds)]
            play += ["--wait", "60", "--settle", str(2.0 * slowdown())]
            start = partial(processes.start, PLAYER, [sys.executable, "-m", *play], env)
            return observe(taps, env["ROS_DOMAIN_ID"], processes, start, progress)
        finally:
            processes.stop()


def observe(
    kinds: Mapping[str, type],
    domain: str,
    processes: ProcessGroup,
    start: Callable[[], None],
    progress: Callable[[int], None],
) -> Measured:
    """Watch topics while a bag is played.

    Args:
        kinds: type of each topic, those that end with SOURCE among them.
        domain: domain of the processes.
        processes: those that are measured, running.
        start: starts the player, as PLAYER.
        progress: called with the number of samples seen.

    Raises:
        LiveRunError: a process failed.
    """
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(domain))
    try:
        node = rclpy.create_node("live_observer", context=context)
        taps = {topic: tap(node, kind, topic) for topic, kind in kinds.items()}
        found = {topic: Answers() for topic in kinds}
        sources = [topic for topic in kinds if topic.endswith(SOURCE)]
        estimated = [each for topic, each in taps.items() if topic not in sources]

        def take_until(condition: Callable[[], bool]) -> None:
            while not condition():
                time.sleep(_TAKE_PERIOD)
                for topic, subscription in taps.items():
                    found[topic].take(subscription)
                for name, code in processes.ended().items():
                    if code != 0 or name != PLAYER:
                        text = "\n".join(processes.log(name).read_text(errors="replace").splitlines()[-15:])
                        raise LiveRunError(f"{name} ended with code {code}:\n{text}")
                progress(len(found[sources[0]].published))

        def after(seconds: float) -> Callable[[], bool]:
            until = time.monotonic() + seconds
            return lambda: time.monotonic() > until

        late = after(_START_LIMIT * slowdown())
        take_until(lambda: all(each.get_publisher_count() for each in estimated) or late())
        start()
        take_until(lambda: bool(found[sources[0]].published) or PLAYER in processes.ended())
        begun, before = time.monotonic(), processes.processor_times()
        take_until(lambda: PLAYER in processes.ended())
        passed = time.monotonic() - begun
        used = {
            name: (now - before[name]) / passed for name, now in processes.processor_times().items() if name in before
        }
        take_until(after(_QUIET * slowdown()))
        node.destroy_node()
        return Measured(used, found)
    finally:
        rclpy.try_shutdown(context=context)
