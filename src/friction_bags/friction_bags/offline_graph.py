"""The wheel processors of several estimators connected without middleware: what the nodes do, in one process."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from friction_runtime.processor import Output, Processor


class OfflineGraph:
    """Passes messages to the processors that take them, and theirs in turn to those behind."""

    def __init__(self, processors: Sequence[Processor]) -> None:
        """Connect processors by their topics.

        Args:
            processors: all that take part, in any order.
        """
        self.inputs: dict[str, type] = {}
        self.outputs: dict[str, type] = {}
        self._readers: dict[str, list[Processor]] = {}
        for processor in processors:
            self.outputs.update(processor.outputs)
            for topics in (processor.sensors, processor.estimates):
                self._connect(processor, topics)

    def feed(self, topic: str, message: Any) -> list[Output]:
        """Take one message; return what all processors give because of it, in order."""
        given: list[Output] = []
        waiting: deque[Output] = deque([(topic, message)])
        while waiting:
            name, each = waiting.popleft()
            for processor in self._readers.get(name, ()):
                outputs = processor.process(name, each)
                given.extend(outputs)
                waiting.extend(output for output in outputs if output[0] in self._readers)
        return given

    def _connect(self, processor: Processor, topics: Mapping[str, type]) -> None:
        for topic, kind in topics.items():
            self.inputs[topic] = kind
            readers = self._readers.setdefault(topic, [])
            if processor not in readers:
                readers.append(processor)


@dataclass(frozen=True)
class GraphPart:
    """Processors that can run without the others."""

    processors: tuple[Processor, ...]
    outputs: frozenset[str]
    """Topics of which it is the one to give the messages."""


def independent_parts(processors: Sequence[Processor], most: int) -> list[GraphPart]:
    """Divide processors by wheel into at most so many parts that need nothing of each other.

    A processor with outputs for several wheels (wheel_slip) runs in every part. What cannot be divided is one part. The
    first of several parts has one wheel: its process also copies topics and writes all outputs, which takes as long as
    another wheel or two.
    """
    outputs = {topic for processor in processors for topic in processor.outputs}
    whole = [GraphPart(tuple(processors), frozenset(outputs))]
    wheels_of = [{_wheel(topic) for topic in processor.outputs} for processor in processors]
    wheels = list(dict.fromkeys(wheel for each in wheels_of if len(each) == 1 for wheel in each))
    parts = []
    for share in _shares(wheels, most):
        others = set(wheels) - set(share)
        chosen = [each for each, names in zip(processors, wheels_of, strict=True) if not names <= others]
        needed = {topic for each in chosen for topics in (each.sensors, each.estimates) for topic in topics}
        made = {topic for each in chosen for topic in each.outputs}
        if (needed & outputs) - made:
            return whole
        given = {topic for topic in made if _wheel(topic) not in others}
        parts.append(GraphPart(tuple(chosen), frozenset(given)))
    return parts if frozenset().union(*(part.outputs for part in parts)) == outputs else whole


def _shares(wheels: list[str], most: int) -> list[list[str]]:
    if most == 1 or len(wheels) < 2:
        return [wheels]
    rest = wheels[1:]
    return [wheels[:1], *(rest[first :: most - 1] for first in range(min(most - 1, len(rest))))]


def _wheel(topic: str) -> str:
    return topic.split("/", 1)[0]
