"""One run of the estimators over a bag without middleware: messages of the bag in, a bag with their outputs out."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from friction_bags.bag_format import BagError, Topic
from friction_bags.bag_reader import BagReader
from friction_bags.bag_writer import BagWriter
from friction_bags.cdr import encode, installed_topic, type_name
from friction_bags.estimators import SMART_TYRE, WHEEL_ESTIMATORS, build_processors
from friction_bags.offline_graph import OfflineGraph

_CHUNK_SIZE = 4 << 20
_MOST_REPORTS = 100
_WHEEL_STATES = "wheel_states"
_TYRE_SIGNALS = "/tyre_signals"


@dataclass(frozen=True)
class ProcessOptions:
    """What is done to each bag."""

    estimators: tuple[str, ...]
    """Names of estimators; empty for all whose inputs the bag has."""
    wheels: tuple[str, ...]
    """Names of the wheels; empty for those of the bag."""
    parameter_files: tuple[Path, ...]
    """ROS parameter files over those that the packages ship."""
    namespace: str
    """Of the topics, e.g. /car; / for none."""
    outputs_only: bool
    """Whether to leave out the topics of the bag."""


@dataclass(frozen=True)
class ProcessResult:
    """What was done to a bag."""

    bag: str
    messages: int
    """Read."""
    outputs: int
    """Made by the estimators."""
    duration: float
    """[s] of the bag."""
    seconds: float
    """[s] it took."""
    problems: tuple[str, ...]


def process_bag(bag: Path, out: Path, options: ProcessOptions, progress: Callable[[float], None]) -> ProcessResult:
    """Run the estimators over a bag and write a bag of its topics and theirs.

    Topics of the bag that the estimators make are replaced. An output is recorded at the stamp of the message that
    caused it. Two runs give the same bytes.

    Args:
        bag: to be read.
        out: to be made.
        options: what to do.
        progress: is told the part that is done, 0 to 1.

    Raises:
        BagError: the bag cannot be read, has no wheel_states, or the other cannot be made.
        ParameterError: a parameter is bad.
    """
    begun = perf_counter()
    with BagReader(bag) as reader:
        prefix = options.namespace.rstrip("/") + "/"
        wheels = options.wheels or _wheels_of(reader, prefix)
        estimators = options.estimators or _estimators_for(reader, prefix)
        graph = OfflineGraph(build_processors(estimators, wheels, options.parameter_files, SayOnce()))
        with BagWriter(out, chunk_size=_CHUNK_SIZE, custom_data=reader.custom_data) as writer:
            return _Run(reader, writer, graph, prefix, options.outputs_only).run(begun, progress)


class SayOnce:
    """Report of processors: each text once."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(self, severity: str, text: str) -> None:
        """Print what was not printed before, except mere information."""
        if severity != "info" and text not in self._said and len(self._said) < _MOST_REPORTS:
            self._said.add(text)
            print(f"{severity}: {text}", file=sys.stderr)


class _Run:
    """One pass over a bag."""

    def __init__(
        self, reader: BagReader, writer: BagWriter, graph: OfflineGraph, prefix: str, outputs_only: bool
    ) -> None:
        self._reader = reader
        self._writer = writer
        self._graph = graph
        self._copied: dict[Topic, int] = {}
        self._taken: dict[Topic, tuple[str, Any]] = {}
        for topic in reader.counts:
            name = topic.name.removeprefix(prefix)
            if name in graph.outputs:
                continue
            if not outputs_only:
                self._copied[topic] = writer.add_topic(topic)
            kind = graph.inputs.get(name)
            if kind is not None and type_name(kind) == topic.type:
                self._taken[topic] = (name, kind)
            elif kind is not None:
                print(f"warning: {topic.name} is {topic.type}, not {type_name(kind)}: not taken", file=sys.stderr)
        self._made = {
            name: writer.add_topic(installed_topic(prefix + name, kind)) for name, kind in graph.outputs.items()
        }

    def run(self, begun: float, progress: Callable[[float], None]) -> ProcessResult:
        """Process all messages."""
        reader = self._reader
        total = max(reader.message_count, 1)
        count = outputs = 0
        for topic, stamp, data in reader.messages({**self._copied, **self._taken}):
            count += 1
            if topic in self._copied:
                self._writer.write(self._copied[topic], stamp, data)
            if topic in self._taken:
                name, kind = self._taken[topic]
                for made, message in self._graph.feed(name, deserialize_message(data, kind)):
                    self._writer.write(self._made[made], stamp, encode(message))
                    outputs += 1
            if count % 1000 == 0:
                progress(count / total)
        progress(1.0)
        duration = (reader.end - reader.start) * 1e-9
        problems = tuple(reader.problems)
        return ProcessResult(str(reader.bag), count, outputs, duration, perf_counter() - begun, problems)


def _estimators_for(reader: BagReader, prefix: str) -> tuple[str, ...]:
    names = {topic.name.removeprefix(prefix) for topic in reader.counts}
    wheel_estimators = WHEEL_ESTIMATORS if _WHEEL_STATES in names else ()
    return (*wheel_estimators, *((SMART_TYRE,) if any(name.endswith(_TYRE_SIGNALS) for name in names) else ()))


def _wheels_of(reader: BagReader, prefix: str) -> tuple[str, ...]:
    """Wheels that the first wheel_states message names, or those with tyre_signals."""
    states = [topic for topic in reader.counts if topic.name == prefix + _WHEEL_STATES]
    for topic, _, data in reader.messages(states):
        if topic.type == type_name(JointState):
            return tuple(deserialize_message(data, JointState).name)
    names = [topic.name.removeprefix(prefix) for topic in reader.counts if topic.name.endswith(_TYRE_SIGNALS)]
    if not names:
        raise BagError(f"{reader.bag} holds no {prefix}{_WHEEL_STATES}: is it in another --namespace?")
    return tuple(name.removesuffix(_TYRE_SIGNALS) for name in sorted(names))
