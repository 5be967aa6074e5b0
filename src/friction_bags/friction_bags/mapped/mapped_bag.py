"""A bag of any car, read as if it held the topics of this graph too."""

from collections.abc import Collection, Iterator
from pathlib import Path

from friction_adapter.ros.processor import AdapterProcessor
from friction_adapter.signal_map import SignalMap
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader, Message
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.mapped.embedded_type import EmbeddedType
from friction_runtime.processor import Output, Report


class MappedBag(BagReader):
    """The topics of a bag, and after each message what a signal map makes of it, recorded at the same time.

    A topic of the bag that the map makes is replaced.
    """

    def __init__(self, bag: Path, signal_map: SignalMap, report: Report, prefix: str = "/") -> None:
        """Open a bag.

        Args:
            bag: directory, or a single storage file.
            signal_map: the map.
            report: log function.
            prefix: prefix of the topics that are made.

        Raises:
            BagError: there is no such bag, nothing in it can be read, or it lacks a topic of the map.
            ParameterError: the map names a field that a type does not have.
        """
        super().__init__(bag)
        for text in signal_map.cannot:
            report("warning", f"{signal_map.path}: {text}")
        self._stamp = 0
        there = {topic.name: topic for topic in super().counts}
        types = {name: EmbeddedType(there[name]) for name in signal_map.topics if name in there}
        fields = {there[name].type: each.fields for name, each in types.items()}
        for name, kind in signal_map.topics.items():
            if name not in there:
                raise BagError(f"{bag} has no topic {name}, which {signal_map.path} names: it has {', '.join(there)}")
            if there[name].type != kind:
                raise BagError(f"{bag}: {name} is {there[name].type}, and {kind} in {signal_map.path}")
        self._processor = AdapterProcessor(signal_map, fields.__getitem__, report, arrival=lambda: self._stamp)
        for name in self._processor.types:
            if name not in there:
                raise BagError(f"{bag} has no topic {name}, which {signal_map.path} names: it has {', '.join(there)}")
        self._types = {there[name]: types.get(name) or EmbeddedType(there[name]) for name in self._processor.types}
        self._made = {
            topic: installed_topic(f"{prefix}{topic}", kind) for topic, kind in self._processor.outputs.items()
        }
        self._replaced = {topic.name for topic in self._made.values()}
        """Names of the topics that are made."""
        self._vehicle = signal_map.vehicle_reference
        self._undecoded: set[str] = set()

    @property
    def counts(self) -> dict[Topic, int]:
        """Messages of each topic; zero for those that are made, whose number is not known before."""
        kept = {topic: count for topic, count in super().counts.items() if topic.name not in self._replaced}
        return {**kept, **dict.fromkeys(self._made.values(), 0)}

    @property
    def made(self) -> tuple[Topic, ...]:
        """Topics that the map makes."""
        return tuple(self._made.values())

    @property
    def custom_data(self) -> dict[str, str]:
        """Notes of the bag; the car is that of the map."""
        return {**super().custom_data, VEHICLE_NOTE: self._vehicle}

    def messages(
        self, topics: Collection[Topic] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]:
        """Yield topic, recording stamp [ns] and CDR data, as BagReader does."""
        wanted = set(self.counts if topics is None else topics)
        self._processor.reset()
        read = [topic for topic in super().counts if topic in wanted or topic in self._types]
        for topic, stamp, data in super().messages(read, start, stop):
            if topic in wanted and topic.name not in self._replaced:
                yield topic, stamp, data
            for name, message in self._outputs(topic, stamp, data):
                if self._made[name] in wanted:
                    yield self._made[name], stamp, encode(message)

    def _outputs(self, topic: Topic, stamp: int, data: bytes) -> Collection[Output]:
        kind = self._types.get(topic)
        if kind is None:
            return ()
        self._stamp = stamp
        try:
            message = kind.decode(data)
        except ValueError as error:
            if topic.name not in self._undecoded:
                self._undecoded.add(topic.name)
                self.problems.append(f"{topic.name}: {error}")
            return ()
        return self._processor.process(topic.name, message)
