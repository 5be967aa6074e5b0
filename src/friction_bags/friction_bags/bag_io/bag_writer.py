"""Writing of rosbag2 bags: one mcap file of the ros2 profile with embedded definitions, and metadata.yaml."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from shutil import rmtree
from types import TracebackType
from typing import Any, Literal

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2.metadata import dump_qos_v9

from friction_bags.bag_io.bag_format import BagError, Contents, Topic, write_metadata
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_runtime.messages import to_nanoseconds

Compression = Literal["zstd", "lz4", "none"]
_COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}


class BagWriter:
    """A bag of one mcap file. Leaving the context closes it, after an error too: what was written by then is kept."""

    def __init__(
        self,
        bag: Path,
        *,
        compression: Compression = "zstd",
        chunk_size: int = 4 << 20,
        custom_data: Mapping[str, str] | None = None,
    ) -> None:
        """Make the directory and the file.

        Args:
            bag: directory to be made; it must not exist.
            compression: compression of each chunk.
            chunk_size: size at which a chunk is closed [bytes].
            custom_data: notes for metadata.yaml.

        Raises:
            BagError: the directory exists or cannot be made.
        """
        self._name = f"{bag.name}_0.mcap"
        try:
            bag.mkdir(parents=True)
            self._file = (bag / self._name).open("xb")
        except FileExistsError:
            raise BagError(f"{bag} exists: give another name, or remove it; nothing is overwritten") from None
        except OSError as error:
            raise BagError(f"{bag} cannot be made: {error.strerror}") from error
        self._mcap = Writer(self._file, chunk_size, _COMPRESSIONS[compression])
        self._mcap.start("ros2", "friction_bags")
        self._bag = bag
        self._custom_data = dict(custom_data or {})
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[Topic, int] = {}
        self._counts: dict[int, int] = {}
        self._span: tuple[int, int] | None = None
        self._open = True

    def add_topic(self, topic: Topic) -> int:
        """Declare a topic, once; return its channel."""
        if (known := self._channels.get(topic)) is not None:
            return known
        key = topic.type, topic.definition
        if key not in self._schemas:
            encoding = topic.definition_encoding
            self._schemas[key] = self._mcap.register_schema(topic.type, encoding, topic.definition.encode())
        qos = yaml.safe_dump(dump_qos_v9(list(topic.qos)), sort_keys=False).strip()
        metadata = {"offered_qos_profiles": qos, "topic_type_hash": topic.type_hash}
        channel = self._mcap.register_channel(topic.name, "cdr", self._schemas[key], metadata)
        self._channels[topic] = channel
        self._counts[channel] = 0
        return channel

    def write(self, channel: int, stamp: int, data: bytes, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message.

        Args:
            channel: channel, from add_topic.
            stamp: recording time [ns].
            data: CDR with its encapsulation header.
            sent: time [ns] at which it was published; the recording time where unknown.
            sequence: number given by the publisher, 0 where unknown.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._mcap.add_message(channel, stamp, data, stamp if sent is None else sent, sequence & 0xFFFFFFFF)
        except OSError as error:
            raise self._failed(error) from error
        self._counts[channel] += 1
        begin, end = self._span or (stamp, stamp)
        self._span = min(begin, stamp), max(end, stamp)

    def flush(self) -> None:
        """Close the present chunk and hand it to the operating system: it survives a kill of this process.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._mcap.flush()
        except OSError as error:
            raise self._failed(error) from error

    def close(self) -> None:
        """Write index, footer and metadata.yaml; a second call does nothing.

        Raises:
            BagError: the disk is full or fails.
        """
        if not self._open:
            return
        self._open = False
        counts = {topic: self._counts[channel] for topic, channel in self._channels.items()}
        contents = Contents(self._name, counts, *(self._span or (0, 0)))
        try:
            self._mcap.finish()
            self._file.close()
            write_metadata(self._bag, "mcap", [contents], self._custom_data)
        except OSError as error:
            raise self._failed(error) from error

    def __enter__(self) -> "BagWriter":
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close; nothing is left of a bag that an error ended before its first message."""
        self.close()
        if kind is not None and self._span is None:
            rmtree(self._bag, ignore_errors=True)

    def _failed(self, error: OSError) -> BagError:
        self._open = False
        with suppress(OSError):
            self._file.close()
        return BagError(
            f"{self._bag}: writing failed: {error.strerror}. What was flushed before is kept: "
            f"make room, then run `python3 -m friction_bags reindex {self._bag}`"
        )


def write_bag(bag: Path, messages: Iterable[tuple[str, Any]], notes: Mapping[str, str]) -> int:
    """Write topics and messages with a header to a bag, recorded at their stamps; return their number.

    Raises:
        BagError: the bag cannot be made.
    """
    channels: dict[str, int] = {}
    count = 0
    with BagWriter(bag, custom_data=notes) as writer:
        for name, message in messages:
            if name not in channels:
                channels[name] = writer.add_topic(installed_topic(name, type(message)))
            writer.write(channels[name], to_nanoseconds(message.header.stamp), encode(message))
            count += 1
    return count
