"""Each estimator as a process, under typed garbage and raw bytes over DDS: alive afterwards, and as good as before.

A clean drive is published in real time again and again, under stamps that go with the clock. In the first part two of
three messages are broken. Then it is published as it is, until the node answers as the processor does without
middleware, at most a few times. It begins at 30 m/s and ends with a slow wheel, and no car leaps from one to the other:
so there is a pause before each clean drive, over which no sensor is compared with its past.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from numpy.random import Generator
from rclpy.node import Node
from rclpy.publisher import Publisher

from benchmarks.runner import Row, at_least, at_most
from campaigns.dds import arrived, tap, use_of
from campaigns.fuzz.garbage import START, clean_run, fuzzed_parameters, garbage, impossible, raw_garbage
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS
from friction_bags.bag_io.cdr import encode
from friction_bags.offline.estimators import make_processors
from friction_bringup import graph
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_runtime import qos
from friction_runtime.domain import free_domain_id
from friction_runtime.installed import shipped_file, shipped_parameters
from friction_runtime.messages import header_at, to_nanoseconds
from friction_runtime.processor import ProcessorGraph, silent
from friction_test_support.machine_load import slowdown
from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "chapter_corner"
_SECONDS = 2.0
"""Length of the clean drive."""
_START_LIMIT = 60.0
_CLEAN_DRIVES = 8
"""Most clean drives until the answers must be right again."""
_PAUSE = 1.5
"""Before each clean drive [s]: longer than the second for which a sensor that contradicted itself is not trusted."""
_LEAST_SHARE = 0.95
"""Of the answers to a clean drive, those that are there and valid where they are without middleware."""
_LARGEST_MEMORY = 300e6
"""Largest resident memory of a node afterwards [B]."""
_DEFECT = "defect:"
"""What the log of a node says of an exception of its processor."""
_Answers = dict[tuple[str, int], bool]
"""Validity by topic and stamp [ns]."""


def live_rows(nodes: Sequence[str], seconds: float, rng: Generator) -> list[Row]:
    """Send garbage to each node for some time [s]; return its rows."""
    os.environ.update(local_discovery())
    domain = free_domain_id()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    rows: list[Row] = []
    try:
        drive = clean_run(load_vehicle(VEHICLE), _SECONDS)
        for name in nodes:
            with tempfile.TemporaryDirectory(prefix="friction_fuzz_") as logs:
                processes = ProcessGroup(Path(logs))
                node = rclpy.create_node("fuzz", context=context)
                try:
                    env = os.environ | {"ROS_DOMAIN_ID": str(domain)}
                    processes.start(name, _command(name), env)
                    rows += _Trial(name, drive, node, processes, rng).rows(seconds)
                finally:
                    processes.stop()
                    node.destroy_node()
    finally:
        rclpy.try_shutdown(context=context)
    return rows


def _command(name: str) -> list[str]:
    """Return the command line of a node with the parameters of fuzzed_parameters."""
    shipped, wanted = (_flat(asdict(each)) for each in (shipped_parameters(name), fuzzed_parameters()[name]))
    changed = {key: value for key, value in wanted.items() if value != shipped[key]}
    return graph.command(name, [shipped_file(name)], {**changed, "vehicle_file": VEHICLE})


def _flat(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            found.update(_flat(value, f"{prefix}{name}."))
        else:
            found[f"{prefix}{name}"] = value
    return found


class _Trial:
    """One node under garbage, and afterwards."""

    def __init__(
        self, name: str, drive: Sequence[tuple[str, Any]], node: Node, processes: ProcessGroup, rng: Generator
    ) -> None:
        """Connect, and wait until the node is there."""
        self._name, self._processes, self._rng = name, processes, rng
        processors = make_processors({name: fuzzed_parameters()[name]}, load_vehicle(VEHICLE), silent)
        without_middleware = ProcessorGraph(processors)
        self._inputs = [(topic, message) for topic, message in drive if topic in without_middleware.inputs]
        answered = [out for topic, message in self._inputs for out in without_middleware.feed(topic, message)]
        self._expected = {(topic, _time(message) - START): _is_valid(message) for topic, message in answered}
        self._publishers: dict[str, Publisher] = {
            topic: qos.publish(node, kind, topic) for topic, kind in without_middleware.inputs.items()
        }
        outputs = [given for processor in processors for given in processor.outputs.items()]
        self._taps = {topic: tap(node, kind, topic) for topic, kind in outputs}
        self._node = node
        self._impossible: list[str] = []
        self._sent = 0
        self._wait_for_node()

    def rows(self, seconds: float) -> list[Row]:
        """Send garbage for some time [s], then clean drives until one is answered."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and self._alive():
            self._drive(self._broken, until)
        share, drives = 0.0, 0
        while share < _LEAST_SHARE and drives < _CLEAN_DRIVES and self._alive():
            share, drives = self._share_of_a_clean_drive(), drives + 1
        log = self._processes.log(self._name).read_text(errors="replace")
        memory = use_of(self._processes.pid(self._name)).rss if self._alive() else np.nan
        defects = [line for line in log.splitlines() if _DEFECT in line]
        judged = (
            ("ended live", at_most(int(not self._alive()), 0), "" if self._alive() else log[-300:]),
            ("exceptions live", at_most(len(defects), 0), next(iter(defects), "")),
            ("impossible valid estimate, live", at_most(len(self._impossible), 0), next(iter(self._impossible), "")),
            ("share of a clean drive answered as before", at_least(share, _LEAST_SHARE), f"drive {drives}"),
            ("memory afterwards [B]", at_most(memory, _LARGEST_MEMORY), ""),
        )
        return [
            {"processor": self._name, "messages": self._sent, "quantity": quantity, **result, "first": first}
            for quantity, result, first in judged
        ]

    def _wait_for_node(self) -> None:
        limit = time.monotonic() + _START_LIMIT * slowdown()
        while not (
            all(each.get_subscription_count() for each in self._publishers.values())
            and all(each.get_publisher_count() for each in self._taps.values())
        ):
            if time.monotonic() > limit or not self._alive():
                log = self._processes.log(self._name).read_text(errors="replace")
                raise RuntimeError(f"{self._name} did not start: {log[-1000:]}")
            time.sleep(0.05)

    def _alive(self) -> bool:
        return self._name not in self._processes.ended()

    def _broken(self, topic: str, message: Any) -> Any:
        """Return a message, a broken one or bytes in its place."""
        chance = self._rng.random()
        if chance < 1.0 / 3.0:
            return garbage(message, self._rng)
        return raw_garbage(encode(message), self._rng) if chance < 2.0 / 3.0 else message

    def _share_of_a_clean_drive(self) -> float:
        found: _Answers = {}
        time.sleep(_PAUSE)
        self._take(None)
        begun = self._drive(lambda topic, message: message, np.inf, found)
        quiet = time.monotonic() + slowdown()
        wanted = {(topic, stamp + begun): valid for (topic, stamp), valid in self._expected.items()}
        while not wanted.keys() <= found.keys() and time.monotonic() < quiet and self._alive():
            time.sleep(0.02)
            self._take(found)
        # A node that remembers the drive before may be sure of a curve earlier.
        right = sum(at in found and found[at] >= valid for at, valid in wanted.items())
        return right / len(wanted)

    def _drive(self, change: Callable[[str, Any], Any], until: float, found: _Answers | None = None) -> int:
        """Publish the drive once, in real time; return the stamp of its begin [ns]."""
        begun, shift = time.monotonic(), time.time_ns() - START
        for topic, message in self._inputs:
            stamp = _time(message)
            due = begun + (stamp - START) / SAMPLE_TIME_NS * SAMPLE_TIME
            while (left := due - time.monotonic()) > 0.0:
                time.sleep(left)
                self._take(found)
            if time.monotonic() > until or not self._alive():
                break
            sent = deepcopy(message)
            sent.header = header_at(stamp + shift, message.header.frame_id)
            self._publishers[topic].publish(change(topic, sent))
            self._sent += 1
        self._take(found)
        return START + shift

    def _take(self, found: _Answers | None) -> None:
        for topic, subscription in self._taps.items():
            for message, _ in arrived(subscription):
                if text := impossible(message):
                    self._impossible.append(text)
                if found is not None:
                    found[topic, _time(message)] = _is_valid(message)


def _time(message: Any) -> int:
    return to_nanoseconds(message.header.stamp)


def _is_valid(message: Any) -> bool:
    return not hasattr(message, "validity") or bool(message.validity.valid)
