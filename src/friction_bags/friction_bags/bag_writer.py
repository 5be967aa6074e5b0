"""Crash-safe writing of rosbag2 bags: mcap, ros2 profile, embedded definitions, chunks handed to the system in time."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Literal

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2.metadata import dump_qos_v9

from friction_bags.bag_format import BagError, Contents, Topic, write_metadata

Compression = Literal["zstd", "lz4", "none"]
_COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}


class McapWriter:
    """One mcap file: what was flushed survives a kill of the process (not a loss of power)."""

    def __init__(self, path: Path, *, compression: Compression = "zstd", chunk_size: int = 1 << 20) -> None:
        """Create the file.

        Args:
            path: of the file, which must not exist.
            compression: of each chunk.
            chunk_size: bytes at which a chunk is closed.

        Raises:
            OSError: the file exists or cannot be made.
        """
        self._file = path.open("xb")
        self._writer = Writer(self._file, chunk_size=chunk_size, compression=_COMPRESSIONS[compression])
        self._writer.start(profile="ros2")
        self._name = path.name
        self._channels: dict[Topic, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._counts: dict[int, int] = {}
        self._start: int | None = None
        self._end = 0

    def add_topic(self, topic: Topic) -> int:
        """Declare a topic, once; return its channel."""
        if topic in self._channels:
            return self._channels[topic]
        key = (topic.type, topic.definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                topic.type, topic.definition_encoding, topic.definition.encode()
            )
        channel = self._writer.register_channel(
            topic.name,
            "cdr",
            self._schemas[key],
            {
                "offered_qos_profiles": yaml.safe_dump(dump_qos_v9(list(topic.qos)), sort_keys=False).strip(),
                "topic_type_hash": topic.type_hash,
            },
        )
        self._channels[topic] = channel
        self._counts[channel] = 0
        return channel

    def write(self, channel: int, stamp: int, data: bytes, *, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message.

        Args:
            channel: of add_topic.
            stamp: recording time [ns].
            data: CDR with its encapsulation header.
            sent: time [ns] at which it was published; the recording time where unknown.
            sequence: number given by the publisher, 0 where unknown.
        """
        self._writer.add_message(channel, stamp, data, stamp if sent is None else sent, sequence)
        self._counts[channel] += 1
        self._start = stamp if self._start is None else min(self._start, stamp)
        self._end = max(self._end, stamp)

    def flush(self) -> None:
        """Close the present chunk and hand everything to the operating system."""
        self._writer.flush()

    def abandon(self) -> None:
        """Close as it is, after an error."""
        with suppress(OSError):
            self._file.close()

    def finish(self) -> Contents:
        """Write index and footer, close, and say what the file holds."""
        try:
            self._writer.finish()
        finally:
            self._file.close()
        counts = {topic: self._counts[channel] for topic, channel in self._channels.items()}
        return Contents(self._name, counts, self._start or 0, self._end)


class BagWriter:
    """A bag of one mcap file. Leaving the context closes it, after an error too: what was written is kept."""

    def __init__(
        self,
        bag: Path,
        *,
        compression: Compression = "zstd",
        chunk_size: int = 1 << 20,
        custom_data: Mapping[str, str] | None = None,
    ) -> None:
        """Make the directory and the file.

        Args:
            bag: directory to be made; it must not exist.
            compression: of each chunk.
            chunk_size: bytes at which a chunk is closed.
            custom_data: notes for metadata.yaml.

        Raises:
            BagError: the directory exists or cannot be made.
        """
        try:
            bag.mkdir(parents=True)
            self._file = McapWriter(bag / f"{bag.name}_0.mcap", compression=compression, chunk_size=chunk_size)
        except FileExistsError:
            raise BagError(f"{bag} exists: give another name, or remove it; nothing is overwritten") from None
        except OSError as error:
            raise BagError(f"{bag} cannot be made: {error.strerror}") from error
        self._bag = bag
        self._custom_data = dict(custom_data or {})
        self._open = True

    def add_topic(self, topic: Topic) -> int:
        """Declare a topic, once; return its channel."""
        return self._file.add_topic(topic)

    def write(self, channel: int, stamp: int, data: bytes, *, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message, see McapWriter.write.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._file.write(channel, stamp, data, sent=sent, sequence=sequence)
        except OSError as error:
            raise self._failed(error) from error

    def flush(self) -> None:
        """Make what was written so far survive a kill of this process.

        Raises:
            BagError: the disk is full or fails.
        """
        try:
            self._file.flush()
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
        try:
            write_metadata(self._bag, "mcap", [self._file.finish()], self._custom_data)
        except OSError as error:
            raise self._failed(error) from error

    def __enter__(self) -> "BagWriter":
        """Give itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _failed(self, error: OSError) -> BagError:
        self._open = False
        self._file.abandon()
        return BagError(
            f"{self._bag}: writing failed: {error.strerror}. What was flushed before is kept: "
            f"make room, then run `python -m friction_bags reindex {self._bag}`"
        )
