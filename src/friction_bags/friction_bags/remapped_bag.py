"""A bag of any car, read through a signal map as if it held the topics of this graph too."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from friction_adapter.ros.processor import AdapterProcessor
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import Fields
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader, Message
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic, message_definition
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.processor import Output, Report

_PADDING = 4
"""Bytes that rclpy appends to a message that ends with an empty sequence of doubles."""
_SHOW_EVERY = 1000


class EmbeddedType:
    """The type of one topic."""

    def __init__(self, topic: Topic) -> None:
        """Read the definition.

        Raises:
            BagError: the bag holds none, or a damaged one, and the type is not installed.
        """
        self._name = topic.type
        self._kind: Any = None
        try:
            self._kind = message_class(topic.type)
            text, encoding = message_definition(topic.type).text, "ros2msg"
        except UnknownTypeError as error:
            if not topic.definition:
                raise BagError(f"{topic.name}: {error}; the bag holds no definition of it") from error
            text, encoding = topic.definition, topic.definition_encoding
        self._store: Any = get_typestore(Stores.EMPTY)
        try:
            of_text = (
                get_types_from_idl(_without_lines_of_tools(text))
                if encoding == "ros2idl"
                else get_types_from_msg(text, topic.type)
            )
            self._store.register(of_text)
            self.fields = fields_in(self._store, topic.type)
            """Fields of the type."""
        except Exception as error:  # rosbags passes on whatever its parser raises
            raise BagError(f"{topic.name}: the definition of {topic.type} cannot be read") from error

    def decode(self, data: bytes) -> Any:
        """Decode CDR to an object with the fields of the message.

        Raises:
            ValueError: the data is not a message of this type.
        """
        if self._kind is not None:
            return decode(data, self._kind)
        try:
            return self._store.deserialize_cdr(data, self._name)
        except SerdeError as error:
            with suppress(SerdeError):
                return self._store.deserialize_cdr(data[:-_PADDING], self._name)
            raise ValueError(f"not a {self._name}: {error}") from error


def _without_lines_of_tools(text: str) -> str:
    """Return an IDL definition without what stands between the files of a type and names them, and without includes."""
    lines = text.splitlines()
    return "\n".join(line for line in lines if not line.startswith(("#include", "=====", "IDL: ")))


def fields_in(store: Any, type_name: str) -> Fields:
    """Return the fields of a type in a store of rosbags.

    Raises:
        KeyError: it, or one that it refers to, is not there.
    """
    return Fields({name: _fields(store, description) for name, description in store.fielddefs[type_name][1]})


def _fields(store: Any, description: Any) -> Fields:
    kind, details = description
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return Fields(_fields(store, details[0]).members, is_sequence=True)
    return fields_in(store, details) if kind == Nodetype.NAME else Fields({})


class RemappedBag(BagReader):
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

    def never_read(self) -> list[str]:
        """Return a sentence for each signal of the map that has not had one value so far."""
        return self._processor.never_read()

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


def write_remapped(
    bag: RemappedBag, out: Path, notes: Mapping[str, str], progress: Callable[[float], None] = lambda _: None
) -> int:
    """Write what the map makes, recorded with the messages that completed it; return the number of messages.

    Args:
        bag: the bag.
        out: bag to write.
        notes: notes of the new bag, in addition to its car.
        progress: called with the share that is done, 0 to 1.

    Raises:
        BagError: the new bag cannot be made, or not one message comes of the bag; nothing is left then.
    """
    duration = max(bag.end - bag.start, 1)
    count = 0
    with BagWriter(out, custom_data={**notes, VEHICLE_NOTE: bag.custom_data[VEHICLE_NOTE]}) as writer:
        channels = {topic: writer.add_topic(topic) for topic in bag.made}
        for topic, stamp, data in bag.messages(bag.made):
            writer.write(channels[topic], stamp, data)
            count += 1
            if count % _SHOW_EVERY == 0:
                progress((stamp - bag.start) / duration)
        if not count:
            raise BagError(f"{bag.bag}: not one message comes of it: {'; '.join(bag.never_read()) or 'it is empty'}")
    bag.problems.extend(bag.never_read())
    return count
