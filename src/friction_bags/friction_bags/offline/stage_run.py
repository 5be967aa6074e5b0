"""A stage of the estimators over the encoded messages of a bag."""

from collections.abc import Mapping
from typing import Any

from friction_bags.bag_io.cdr import decode, encode
from friction_bags.offline.graph_stages import Stage
from friction_runtime.processor_graph import ProcessorGraph

Outputs = list[tuple[int, bytes]]
"""Topic number and CDR of each output for one message."""


class StageRun:
    """Takes the messages of a bag with the outputs of the stages before, adds its own.

    Messages that cannot be decoded are skipped, and counted by topic in `refused`.
    """

    def __init__(self, stage: Stage, numbers: Mapping[str, int]) -> None:
        """Start without messages.

        Args:
            stage: processors of the stage.
            numbers: numbers of the topics that the processors of all stages make.
        """
        self._graph = ProcessorGraph(stage)
        self._numbers = dict(numbers)
        self._names = list(numbers)
        self.refused: dict[str, int] = {}

    def take(self, name: str, data: bytes, outputs: Outputs) -> None:
        """Take a message with its relative topic and its outputs so far; append those of this stage."""
        made = [(self._names[number], encoded) for number, encoded in outputs]
        self._feed(name, data, outputs)
        for topic, encoded in made:
            self._feed(topic, encoded, outputs)

    def _feed(self, name: str, data: bytes, outputs: Outputs) -> None:
        kind = self._graph.inputs.get(name)
        if kind is None:
            return
        try:
            message: Any = decode(data, kind)
        except ValueError:
            self.refused[name] = self.refused.get(name, 0) + 1
            return
        for topic, made in self._graph.feed(name, message):
            outputs.append((self._numbers[topic], encode(made)))
