"""Soak graph: a corner with a smart tyre that brakes lap after lap, all estimators, and the answers of each lap."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

import numpy as np
import rclpy
from friction_msgs.msg import (
    BrakeCommand,
    ContactPatch,
    FrictionCurve,
    FrictionSlope,
    SlopeVote,
    SupervisorState,
    WheelSlip,
)
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from campaigns.dds import ProcessUse, arrived, tap, use_of
from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, WHEEL_ESTIMATORS
from friction_bags.record_replay.flow_control import header_stamp
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.node_start import commanding, node_starts
from friction_bringup.processes import ProcessGroup
from friction_runtime.domain import free_domain_id
from friction_test_support.machine_load import slowdown
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason


@dataclass
class Seen:
    """Publications [ns, wall clock] of each stamp [ns] of one topic: a command is repeated as a heartbeat."""

    published: dict[int, list[int]] = field(default_factory=dict)

    def note(self, stamp: int, at: int) -> None:
        """Take one message."""
        self.published.setdefault(stamp, []).append(at)

    def answer(self, stamp: int, asked: int) -> int | None:
        """Return the first publication [ns] of a stamp since it was asked for [ns], None where there is none.

        What was published before answers the same stamp of the lap before.
        """
        return min((at for at in self.published.get(stamp, ()) if at >= asked), default=None)


@dataclass(frozen=True)
class Answers:
    """What one topic had to say to the samples of a lap."""

    samples: int
    """Samples that were to be answered."""
    lost: int
    """Those that were not."""
    delays: NDArray[np.float64]
    """From the publication of a sample to that of its answer [ms], shape (answers,)."""


def answers(sent: Seen, topic: Seen, begin: int) -> Answers:
    """Compare a topic with wheel_states.

    Args:
        sent: wheel_states.
        topic: what answers it.
        begin: first stamp that is to be answered [ns].
    """
    asked = {stamp: at[0] for stamp, at in sent.published.items() if stamp >= begin}
    first = {stamp: topic.answer(stamp, at) for stamp, at in asked.items()}
    delays = [at - asked[stamp] for stamp, at in first.items() if at is not None]
    return Answers(len(asked), len(asked) - len(delays), np.array(delays, dtype=float) * 1e-6)


def together(parts: Sequence[Answers]) -> Answers:
    """Return the answers in several laps, at least one, as those of one."""
    delays = np.concatenate([part.delays for part in parts])
    return Answers(sum(part.samples for part in parts), sum(part.lost for part in parts), delays)


_VEHICLE = "chapter_corner"
_WHEELS = ("front_left",)
"""Wheels that are observed."""
_SOURCE = "wheel_states"
_PATCHES = "contact_patch"
_KINDS: Mapping[str, type] = {
    "slip": WheelSlip,
    "friction_slope": FrictionSlope,
    "slope_vote": SlopeVote,
    "friction_curve": FrictionCurve,
    "abs_supervisor": SupervisorState,
    "brake_command": BrakeCommand,
}
LAP = 6.0
"""Length of a lap [s]: rolling, a panic stop, standing."""
_PLANT: Mapping[str, graph.ParameterValue] = {
    "initial_speed": 25.0,
    "demand_start": 2.5,
    "end_speed": -1.0,
    "acceleration_variance": 0.01,
    "vehicle_velocity": False,
    "tyre_signals": True,
    "autostart": False,
}
_LAW = "curve"
_TAKE_PERIOD = 0.02
_START_LIMIT = 60.0
_SETTLE = 2.0
"""Wall time [s] before the first lap in which the nodes find each other."""
_TRUSTED_AFTER = 1.0
"""Time after the jump back of the stamps from which samples count [s]: a supervisor that commands trusts stamps again
once they have gone with the clock for half a second, and leaves samples unanswered until then."""
_SILENT = 1.0
"""Wall time [s] without a sample after which a lap counts as over."""
_QUIET = 1.0
"""Wall time [s] after the last sample of a lap in which its last answers arrive."""


class SoakError(RuntimeError):
    """The graph cannot go on; the text says why, with the end of a log."""


class SoakGraph:
    """Starts the processes; ends them on leaving the context."""

    def __init__(self, lap: float = LAP, pace: float = 1.0) -> None:
        """Start them, wait until all are there, and connect.

        Args:
            lap: length of a lap [s].
            pace: message time over wall time; below 1 the supervisor does not watch its inputs by the clock.
        """
        self._lap, self._pace = lap, pace
        os.environ.update(local_discovery())
        domain = free_domain_id()
        self._logs = tempfile.TemporaryDirectory(prefix="friction_soak_")
        self._processes = ProcessGroup(Path(self._logs.name))
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        try:
            self._start(os.environ | {"ROS_DOMAIN_ID": str(domain)})
            self._connect()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> SoakGraph:
        """Return the running graph."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """End the processes."""
        self.close()

    def close(self) -> None:
        """End the processes and the observer."""
        self._processes.stop()
        rclpy.try_shutdown(context=self._context)
        self._logs.cleanup()

    def lap(self) -> dict[str, Answers]:
        """Drive one lap; return what each topic had to say, by topic.

        Raises:
            SoakError: a process has ended, or the plant does not come to the end of the lap.
        """
        self._call("reset")
        self._take()
        self.lost_packets = 0
        self._seen = {topic: Seen() for topic in self._taps}
        self._call("start")
        sent = self._seen[_SOURCE]
        source = sent.published
        self._until(
            lambda: self._has_ended(source),
            self._lap / self._pace + _START_LIMIT,
            lambda: f"the end of a lap: {len(source)} samples came; {self._end_of_log(graph.PLANT)}",
        )
        last = max(source)
        asked = source[last][0]
        quiet = time.monotonic() + _QUIET * slowdown()
        self._until(
            lambda: time.monotonic() > quiet or all(seen.answer(last, asked) for seen in self._seen.values()),
            _START_LIMIT * slowdown(),
            lambda: "the last answers",
        )
        begin = min(source) + round(_TRUSTED_AFTER * NANOSECONDS)
        return {topic: answers(sent, seen, begin) for topic, seen in self._seen.items() if topic != _SOURCE}

    def _has_ended(self, source: Mapping[int, Sequence[int]]) -> bool:
        """Whether the last sample of a lap has come, or should have: on a busy machine this process may lose it."""
        if not source:
            return False
        silent = (time.time_ns() - source[max(source)][-1]) / NANOSECONDS
        return max(source) - min(source) >= round(self._lap * NANOSECONDS) or silent > _SILENT * slowdown()

    def use(self) -> dict[str, ProcessUse]:
        """Return what each process holds now, by the name of its node.

        Raises:
            SoakError: one has ended.
        """
        self._check()
        return {name: use_of(self._processes.pid(name)) for name in (*ESTIMATORS, graph.PLANT)}

    def _start(self, env: Mapping[str, str]) -> None:
        readers = len(WHEEL_ESTIMATORS) + 1  # and this process
        commands = commanding(_LAW)
        plant = {"end_time": self._lap, "real_time_factor": self._pace, "wait_for_subscribers": readers}
        decided = {
            **commands,
            graph.SUPERVISOR: {**commands[graph.SUPERVISOR], "real_time": self._pace >= 1.0},
            SMART_TYRE: {"calibration_file": str(graph.plant_calibration())},
            graph.PLANT: {**_PLANT, **plant},
        }
        for start in node_starts((*ESTIMATORS, graph.PLANT), decided, vehicle_file=_VEHICLE):
            self._processes.start(start.node, graph.command(start.node, start.files, start.decided), env)

    def _connect(self) -> None:
        self._node = node = rclpy.create_node("soak_observer", context=self._context)
        kinds = {_SOURCE: JointState, **{f"{wheel}/{name}": k for wheel in _WHEELS for name, k in _KINDS.items()}}
        self._taps = {topic: tap(node, kind, topic) for topic, kind in kinds.items()}
        self._patches = [tap(node, ContactPatch, f"{wheel}/{_PATCHES}") for wheel in _WHEELS]
        self._seen = {topic: Seen() for topic in self._taps}
        self.lost_packets = 0
        """Contact patches of the present lap that lack blocks of a tyre."""
        self.patches = 0
        """Contact patches since the start."""
        caller = rclpy.create_node("soak_driver", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(caller)
        self._clients = {name: caller.create_client(Trigger, f"/{graph.PLANT}/{name}") for name in ("reset", "start")}
        taps = (*self._taps.values(), *self._patches)
        self._until(
            lambda: (
                all(each.get_publisher_count() for each in taps)
                and all(client.service_is_ready() for client in self._clients.values())
            ),
            _START_LIMIT * slowdown(),
            lambda: "all nodes",
        )
        settled = time.monotonic() + _SETTLE * slowdown()
        self._until(
            lambda: time.monotonic() > settled, _START_LIMIT * slowdown(), lambda: "the nodes to find each other"
        )

    def _call(self, name: str) -> None:
        future = self._clients[name].call_async(Trigger.Request())
        self._executor.spin_until_future_complete(future, _START_LIMIT * slowdown())
        if not future.done():
            raise SoakError(f"/{graph.PLANT}/{name} does not answer")

    def _until(self, condition: Callable[[], bool], limit: float, what: Callable[[], str]) -> None:
        deadline = time.monotonic() + limit
        while not condition():
            if time.monotonic() > deadline:
                raise SoakError(f"waited {limit:.0f} s for {what()}")
            time.sleep(_TAKE_PERIOD)
            self._check()
            self._take()

    def _take(self) -> None:
        """Take all messages that have arrived."""
        for topic, subscription in self._taps.items():
            seen = self._seen[topic]
            for encoded, published in arrived(subscription, raw=True):
                seen.note(header_stamp(encoded), published)
        for subscription in self._patches:
            for patch, _ in arrived(subscription):
                self.lost_packets += patch.validity.reason == Reason.GAP
                self.patches += 1

    def _check(self) -> None:
        for name, code in self._processes.ended().items():
            raise SoakError(f"{name} ended with code {code}; {self._end_of_log(name)}")

    def _end_of_log(self, name: str) -> str:
        return f"{name} says: {' / '.join(self._processes.log(name).read_text(errors='replace').splitlines()[-5:])}"
