"""Records of any source as messages of this graph."""

from collections.abc import Mapping
from typing import Any

from friction_adapter.adapter import Adapter
from friction_adapter.ros.messages import MESSAGE_TYPES, maker
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import Sources
from friction_runtime.processor import Output


class RecordMapper:
    """Takes messages, frames or rows; returns messages."""

    def __init__(self, signal_map: SignalMap, sources: Sources) -> None:
        """Find every signal.

        Raises:
            ParameterError: one is not there; the text names file, line and what there is.
        """
        self._adapter = Adapter(signal_map, sources)
        self._topics = [target.topic for target in self._adapter.targets]
        self._makers = [
            maker(target, stddevs, signal_map.vehicle)
            for target, stddevs in zip(self._adapter.targets, self._adapter.stddevs, strict=True)
        ]
        self.sources = self._adapter.sources
        """Names of the sources that are needed."""
        self.outputs: Mapping[str, type] = {
            target.topic: MESSAGE_TYPES[target.message] for target in self._adapter.targets
        }
        """Relative topics and types of the messages."""

    def take(self, source: str, record: Any, arrival: int) -> list[Output]:
        """Take a record of a source that arrived or was recorded at a time [ns]; return the messages it completes."""
        made = self._adapter.take(source, record, arrival)
        return [(self._topics[each.target], self._makers[each.target](each.stamp, each.values)) for each in made]

    def reset(self) -> None:
        """Start again, as after construction."""
        self._adapter.reset()

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used so far, by what it is; without what never happened."""
        found = {
            **{f"no value for {title}": count for title, count in self._adapter.unreadable.items()},
            "stamp that no message can hold": self._adapter.refused,
            "instant without one of its messages": self._adapter.incomplete,
        }
        return {text: count for text, count in found.items() if count}
