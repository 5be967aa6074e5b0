"""Bags of ROS 1, through rosbags."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import Fields, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.remapped_bag import fields_in
from friction_runtime.processor import Output


class Ros1Log:
    """A bag, read through a signal map. Its types are those of the definitions in the bag, named as in ROS 2."""

    def __init__(self, path: Path, signal_map: SignalMap) -> None:
        """Find the signals of the map.

        Raises:
            BagError: the bag cannot be read, or lacks a topic of the map.
            ParameterError: the map names a field that a type does not have.
        """
        self._path = path
        self._reader = AnyReader([path])
        self._read = 0
        try:
            self._reader.open()
        except Exception as error:  # rosbags passes on errors of every layer below it
            raise BagError(f"{path} cannot be read: {error}") from error
        there = {each.topic: each for each in self._reader.connections}
        for name, kind in signal_map.topics.items():
            if name not in there:
                raise BagError(f"{path} has no topic {name}, which {signal_map.path} names: it has {', '.join(there)}")
            if there[name].msgtype != kind:
                raise BagError(f"{path}: {name} is {there[name].msgtype}, and {kind} in {signal_map.path}")
        self._mapper = RecordMapper(signal_map, Sources(self._fields))
        self._wanted = [each for each in self._reader.connections if each.topic in self._mapper.sources]
        self._total = max(sum(each.msgcount for each in self._wanted), 1)

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages.

        Raises:
            BagError: the bag is damaged; what came before has been yielded.
        """
        for source, message, stamp in self._decoded():
            for topic, made in self._mapper.take(source, message, stamp):
                yield f"/{topic}", made

    @property
    def notes(self) -> Sequence[str]:
        """None."""
        return ()

    def share(self) -> float:
        """Return the share of the messages that have been read."""
        return self._read / self._total

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._mapper.problems_at_end()

    def _decoded(self) -> Iterator[tuple[str, Any, int]]:
        """Yield topic, message and recording stamp [ns] of what the map needs."""
        try:
            for connection, stamp, data in self._reader.messages(self._wanted):
                self._read += 1
                yield connection.topic, self._reader.deserialize(data, connection.msgtype), stamp
        except Exception as error:  # rosbags passes on errors of every layer below it
            raise BagError(f"{self._path} cannot be read to its end: {error}") from error
        finally:
            self._reader.close()

    def _fields(self, type_name: str) -> Fields:
        return fields_in(self._reader.typestore, type_name)
