"""The processors of several estimators, connected in one process without middleware as the nodes are with it."""

from collections.abc import Mapping, Sequence
from typing import Any

from friction_runtime.processor import Output, Processor


class OfflineGraph:
    """Passes messages to the processors that take them, and their outputs to those after them."""

    def __init__(self, processors: Sequence[Processor]) -> None:
        """Connect processors by their topics.

        Args:
            processors: processors of the graph, in any order.
        """
        self.inputs: dict[str, type] = {}
        self._readers: dict[str, list[Processor]] = {}
        for processor in processors:
            for topics in (processor.sensors, processor.estimates):
                self._connect(processor, topics)

    def feed(self, topic: str, message: Any) -> list[Output]:
        """Take one message; return the resulting outputs of all processors, in order."""
        given: list[Output] = []
        self._hand_on(topic, message, given)
        # What is appended on the way is handed on in its turn.
        for name, each in given:
            self._hand_on(name, each, given)
        return given

    def _hand_on(self, topic: str, message: Any, given: list[Output]) -> None:
        readers = self._readers.get(topic)
        if readers is not None:
            for processor in readers:
                given.extend(processor.process(topic, message))

    def _connect(self, processor: Processor, topics: Mapping[str, type]) -> None:
        for topic, kind in topics.items():
            self.inputs[topic] = kind
            readers = self._readers.setdefault(topic, [])
            if processor not in readers:
                readers.append(processor)
