"""Hostile messages into every processor: exceptions, impossible valid estimates, time of an update, recovery.

A clean drive is sent again and again; each time a share of its messages is broken, lost, repeated or exchanged. After
each, the processor is reset and takes the clean drive: its answers must be those after a clean one, bit for bit.
"""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any

import numpy as np
from numpy.random import Generator
from rich.progress import track

from benchmarks.runner import Row, at_most
from campaigns.dds import use_of
from campaigns.fuzz.garbage import clean_run, fuzzed_parameters, garbage, impossible, inputs_of
from campaigns.fuzz.live import live_rows
from campaigns.fuzz.update_time import update_time_rows, wrong_unit_rows
from friction_bags.bag_io.cdr import encode
from friction_bags.offline.estimators import make_processors
from friction_parameters.command_line import count, not_negative
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import silent
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

_VEHICLE = "chapter_car"
_SECONDS = 2.0
"""Length of the clean drive."""
_SHARES = (0.002, 0.02, 0.2, 1.0)
"""Shares of broken messages, in turn: the rarer, the further the broken ones get."""
_LONGEST_FAULT = 200
"""Largest number of messages that a lasting fault breaks in the same way."""
_CURVE_METHODS = ("car", "ml", "rml", "rml_ml", "ls", "rls", "vehicle", "tyre_force")
_OUTLIVE_A_RESET = ("counter", "checksum", "restarts", "restart_cause")
"""Fields by which a receiver sees that messages were lost or that the fit began again: a reset does not rewind them."""
_HUNG = 20.0
"""CPU time of one update after which it is ended [s]."""
_LARGEST_MEMORY = 600.0
"""Largest resident memory after all messages [MB]: a clean drive with smart tyres takes a fifth."""
_MEGABYTE = 1e6
_LARGEST_UPDATE = 1.0
"""Largest CPU time of one update [s], a block of 100 000 samples included."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add its own options."""
    parser.add_argument("--messages", type=count, default=100_000, help="messages in all (1000000 for the record)")
    parser.add_argument("--seed", type=int, default=0, help="seed of what is broken, and how")
    parser.add_argument("--processors", nargs="+", default=[], metavar="NAME", help="only these, such as wheel_slip")
    parser.add_argument("--units", action="store_true", help="then sensors in wrong units on stops of two cars")
    parser.add_argument(
        "--live", type=not_negative, default=0.0, metavar="SECONDS", help="then each node so long over DDS (60)"
    )


def run(options: argparse.Namespace) -> list[Row]:
    """Send the messages; return four rows a processor, and five a node that got garbage over DDS.

    Raises:
        ParameterError: no message, or a processor that is not there.
    """
    if options.messages < 1:
        raise ParameterError("--messages must be at least 1")
    vehicle = load_vehicle(_VEHICLE)
    makers = _makers(vehicle)
    if unknown := set(options.processors) - set(makers):
        raise ParameterError(f"--processors {', '.join(sorted(unknown))}: choose from {', '.join(makers)}")
    chosen = {name: makers[name] for name in makers if not options.processors or name in options.processors}
    drive = clean_run(vehicle, _SECONDS)
    rows: list[Row] = []
    for number, (name, make) in track(list(enumerate(chosen.items())), description="fuzz"):
        rng = np.random.default_rng((options.seed, number))
        rows.extend(_judge(name, make, inputs_of(make(), drive), options.messages // len(chosen), rng))
    rows.extend(update_time_rows(chosen, drive))
    memory = at_most(use_of(os.getpid()).rss / _MEGABYTE, _LARGEST_MEMORY)
    rows.append({"processor": "all", "quantity": "memory of this process at the end [MB]", **memory})
    if options.units:
        rows.extend(wrong_unit_rows())
    if options.live > 0.0:
        nodes = list(dict.fromkeys(make.node for make in chosen.values()))
        rows.extend(live_rows(nodes, options.live, np.random.default_rng(options.seed)))
    return rows


@dataclass(frozen=True)
class _Maker:
    """Makes processors of one kind: the first one of a node, of the car or of its first wheel."""

    node: str
    parameters: Any
    vehicle: Vehicle

    def __call__(self) -> Any:
        return make_processors({self.node: self.parameters}, self.vehicle, silent)[0]


def _makers(vehicle: Vehicle) -> dict[str, _Maker]:
    """One for each node, and for each method of friction_curve_id."""
    found: dict[str, _Maker] = {}
    for node, parameters in fuzzed_parameters().items():
        if node != "friction_curve_id":
            found[node] = _Maker(node, parameters, vehicle)
            continue
        for method in _CURVE_METHODS:
            found[f"{node} {method}"] = _Maker(node, replace(parameters, method=method), vehicle)
    return found


class _Findings:
    """What was found of one processor."""

    def __init__(self) -> None:
        self.messages = 0
        self.exceptions: list[str] = []
        self.impossible: list[str] = []
        self.slowest = 0.0

    def feed(self, processor: Any, topic: str, message: Any) -> list[Any]:
        """Hand on one message; keep what is wrong with the answers."""
        self.messages += 1
        begun = time.thread_time()
        try:
            with _no_longer_than(_HUNG):
                outputs = list(processor.process(topic, message))
        except Exception as problem:  # Whatever it is, it is what is looked for.
            self.exceptions.append(f"{topic}: {type(problem).__name__}: {problem}")
            outputs = []
        self.slowest = max(self.slowest, time.thread_time() - begun)
        self.impossible.extend(text for _, answer in outputs if (text := impossible(answer)))
        return outputs


def _judge(name: str, make: _Maker, inputs: Sequence[tuple[str, Any]], messages: int, rng: Generator) -> list[Row]:
    findings = _Findings()
    processor = make()
    _answers(processor, inputs)
    processor.reset()
    expected = _answers(processor, inputs)
    processor.reset()
    lasting = 0
    drives = 0
    while findings.messages < messages:
        for topic, message in _broken(inputs, _SHARES[drives % len(_SHARES)], rng):
            findings.feed(processor, topic, message)
        processor.reset()
        drives += 1
        lasting += _answers(processor, inputs) != expected
        processor.reset()
    return [
        {"processor": name, "messages": findings.messages, "quantity": quantity, **result, "first": first}
        for quantity, result, first in (
            ("exceptions", at_most(len(findings.exceptions), 0), next(iter(findings.exceptions), "")),
            ("impossible valid estimate", at_most(len(findings.impossible), 0), next(iter(findings.impossible), "")),
            ("clean drives with other answers after a reset", at_most(lasting, 0), ""),
            ("largest CPU time of an update [s]", at_most(findings.slowest, _LARGEST_UPDATE), ""),
        )
    ]


def _answers(processor: Any, inputs: Sequence[tuple[str, Any]]) -> list[bytes]:
    return [_lasting(answer) for topic, message in inputs for _, answer in processor.process(topic, message)]


def _lasting(answer: Any) -> bytes:
    for name in _OUTLIVE_A_RESET:
        if hasattr(answer, name):
            setattr(answer, name, 0)
    return encode(answer)


def _broken(inputs: Sequence[tuple[str, Any]], share: float, rng: Generator) -> Iterator[tuple[str, Any]]:
    """The drive with a share of its messages broken, lost, repeated or exchanged with the next; some faults last."""
    lasting: dict[str, list[int]] = {}
    waiting: tuple[str, Any] | None = None
    for topic, message in inputs:
        seed, left = lasting.get(topic, (0, 0))
        if left:
            lasting[topic] = [seed, left - 1]
            yield topic, garbage(message, np.random.default_rng(seed))
            continue
        kind = rng.random() / share
        if kind < 0.6:
            yield topic, garbage(message, rng)
        elif kind < 0.7:
            lasting[topic] = [int(rng.integers(2**31)), int(rng.integers(1, _LONGEST_FAULT))]
            yield topic, message
        elif kind < 0.8:
            continue
        elif kind < 0.9:
            yield topic, message
            yield topic, message
        elif kind < 1.0 and waiting is None:
            waiting = topic, message
        else:
            yield topic, message
            if waiting is not None:
                yield waiting
                waiting = None


class _TookTooLongError(Exception):
    """An update did not end."""


@contextmanager
def _no_longer_than(seconds: float) -> Iterator[None]:
    """End what takes more CPU time than this by an exception."""

    def end(_number: int, _frame: FrameType | None) -> None:
        raise _TookTooLongError(f"more than {seconds:.0f} s")

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
