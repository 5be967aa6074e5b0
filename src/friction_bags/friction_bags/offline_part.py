"""A part of the estimators over the messages of a bag: here, or in a process of its own that sends its outputs."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from sensor_msgs.msg import JointState

from friction_bags.bag_format import BagError, Topic
from friction_bags.bag_reader import BagReader
from friction_bags.cdr import decode, type_name
from friction_bags.estimators import SMART_TYRE, WHEEL_ESTIMATORS, build_processors
from friction_bags.graph_parts import independent_parts
from friction_bags.offline_graph import OfflineGraph
from friction_bags.part_run import Outputs, PartRun
from friction_runtime.processor import Processor, Report

_WHEEL_STATES = "wheel_states"
_TYRE_SIGNALS = "/tyre_signals"
_BATCH = 128
"""Messages of the bag whose outputs are sent together."""
_MOST_REPORTS = 100


@dataclass(frozen=True)
class ProcessOptions:
    """What is done to each bag."""

    estimators: tuple[str, ...] = ()
    """Names of estimators; empty for all whose inputs the bag has."""
    wheels: tuple[str, ...] = ()
    """Names of the wheels; empty for those of the bag."""
    parameter_files: tuple[Path, ...] = ()
    """ROS parameter files over those that the packages ship."""
    namespace: str = "/"
    """Of the topics, e.g. /car; / for none."""
    outputs_only: bool = False
    """Whether to leave out the topics of the bag."""

    @property
    def prefix(self) -> str:
        """What the names of the topics begin with."""
        return self.namespace.rstrip("/") + "/"


class SayOnce:
    """Report of processors: each text once, without mere information."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(self, severity: str, text: str) -> None:
        """Print what was not printed before."""
        if severity != "info" and text not in self._said and len(self._said) < _MOST_REPORTS:
            self._said.add(text)
            print(f"{severity}: {text}", file=sys.stderr)


def processors_for(reader: BagReader, options: ProcessOptions, report: Report) -> list[Processor]:
    """Make the processors that a bag asks for.

    Raises:
        BagError: it names no wheels.
        ParameterError: a parameter is bad.
    """
    prefix = options.prefix
    names = {topic.name.removeprefix(prefix) for topic in reader.counts}
    estimators = options.estimators
    if not estimators:
        has_tyres = any(name.endswith(_TYRE_SIGNALS) for name in names)
        estimators = (*(WHEEL_ESTIMATORS if _WHEEL_STATES in names else ()), *((SMART_TYRE,) if has_tyres else ()))
    wheels = options.wheels or _wheels_of(reader, prefix)
    return build_processors(estimators, wheels, options.parameter_files, report)


def taken_topics(reader: BagReader, processors: list[Processor], prefix: str) -> dict[Topic, str]:
    """Topics of the bag that processors take and none of them makes, with their relative names."""
    graph = OfflineGraph(processors)
    taken: dict[Topic, str] = {}
    for topic in reader.counts:
        name = topic.name.removeprefix(prefix)
        kind: Any = graph.inputs.get(name)
        if kind is not None and name not in graph.outputs:
            if type_name(kind) == topic.type:
                taken[topic] = name
            else:
                print(f"warning: {topic.name} is {topic.type}, not {type_name(kind)}: not taken", file=sys.stderr)
    return taken


def output_places(processors: list[Processor]) -> dict[str, int]:
    """Numbers of the topics that processors make, in the order in which outputs of one message are written."""
    topics = dict.fromkeys(topic for processor in processors for topic in processor.outputs)
    return {topic: place for place, topic in enumerate(topics)}


def send_outputs(bag: Path, part: int, parts: int, options: ProcessOptions, receiver: Connection) -> None:
    """Run one of several parts over a bag; send, in batches, the outputs after each message that is taken.

    To be called in a process of its own; an exception is sent instead of being raised.
    """
    try:
        with BagReader(bag) as reader:
            processors = processors_for(reader, options, lambda *_: None)
            taken = taken_topics(reader, processors, options.prefix)
            run = PartRun(independent_parts(processors, parts)[part], output_places(processors))
            batch: list[Outputs] = []
            for topic, _, data in reader.messages(taken):
                batch.append(run.take(taken[topic], data))
                if len(batch) == _BATCH:
                    receiver.send(batch)
                    batch = []
            receiver.send(batch)
    except BrokenPipeError:
        pass
    except Exception as error:
        receiver.send(error)


def received_outputs(sender: Connection) -> Iterator[Outputs]:
    """Yield what send_outputs sends, one by one.

    Raises:
        BagError: the other process ended early, or sent an exception.
    """
    while True:
        try:
            batch = sender.recv()
        except EOFError:
            raise BagError("a process of the estimators ended early (out of memory?)") from None
        if isinstance(batch, Exception):
            raise BagError(f"a process of the estimators failed: {batch}") from batch
        yield from batch


def _wheels_of(reader: BagReader, prefix: str) -> tuple[str, ...]:
    """Wheels that the first wheel_states message names, or those with tyre_signals."""
    states = [topic for topic in reader.counts if topic.name == prefix + _WHEEL_STATES]
    for topic, _, data in reader.messages(states):
        if topic.type == type_name(JointState):
            return tuple(decode(data, JointState).name)
    names = [topic.name.removeprefix(prefix) for topic in reader.counts if topic.name.endswith(_TYRE_SIGNALS)]
    if not names:
        raise BagError(f"{reader.bag} holds no {prefix}{_WHEEL_STATES}: is it in another --namespace?")
    return tuple(name.removesuffix(_TYRE_SIGNALS) for name in sorted(names))
