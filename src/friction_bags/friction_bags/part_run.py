"""A part of the estimators over encoded messages: what is done for each message of a bag."""

from collections.abc import Mapping

from friction_bags.cdr import decode, encode
from friction_bags.graph_parts import GraphPart
from friction_bags.offline_graph import OfflineGraph

Outputs = list[tuple[int, bytes]]
"""Number of the topic and CDR of what follows from one message."""


class PartRun:
    """Takes the messages of a bag, gives the outputs of a part of the estimators.

    Messages that cannot be decoded are left out, and counted by topic in `refused`.
    """

    def __init__(self, part: GraphPart, places: Mapping[str, int]) -> None:
        """Start anew.

        Args:
            part: of the graph.
            places: numbers of the topics of all parts.
        """
        self._graph = OfflineGraph(part.processors)
        self._places = {topic: places[topic] for topic in part.outputs}
        self.refused: dict[str, int] = {}

    def take(self, name: str, data: bytes) -> Outputs:
        """Outputs that follow from a message with its relative topic."""
        kind = self._graph.inputs.get(name)
        if kind is None:
            return []
        try:
            message = decode(data, kind)
        except ValueError:
            self.refused[name] = self.refused.get(name, 0) + 1
            return []
        outputs: Outputs = []
        for topic, made in self._graph.feed(name, message):
            place = self._places.get(topic)
            if place is not None:
                outputs.append((place, encode(made)))
        return outputs
