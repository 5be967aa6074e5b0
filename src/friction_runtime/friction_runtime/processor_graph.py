"""The processors of several estimators, connected in one process without middleware as separate nodes are with it."""

from collections.abc import Mapping, Sequence
from typing import Any

from friction_runtime.processor import Output, Reader


class ProcessorGraph:
    """Passes messages to those that take them, and their outputs to those after them.

    Whoever takes a message takes it before any output that it causes: all of a sample's slips are made before the first
    of them is handed on.
    """

    def __init__(self, readers: Sequence[Reader]) -> None:
        """Connect processors, or nodes around them, by their topics.

        Args:
            readers: all that take part; those that take the same topic are given it in this order.
        """
        self.inputs: dict[str, type] = {}
        self._readers: dict[str, list[Reader]] = {}
        for reader in readers:
            for topics in (reader.sensors, reader.estimates):
                self._connect(reader, topics)

    def feed(self, topic: str, message: Any) -> list[Output]:
        """Take one message; return the resulting outputs of all, in order."""
        given: list[Output] = []
        self._hand_on(topic, message, given)
        # What is appended on the way is handed on in its turn.
        for name, each in given:
            self._hand_on(name, each, given)
        return given

    def _hand_on(self, topic: str, message: Any, given: list[Output]) -> None:
        readers = self._readers.get(topic)
        if readers is not None:
            for reader in readers:
                given.extend(reader.process(topic, message))

    def _connect(self, reader: Reader, topics: Mapping[str, type]) -> None:
        for topic, kind in topics.items():
            self.inputs[topic] = kind
            readers = self._readers.setdefault(topic, [])
            if reader not in readers:
                readers.append(reader)
