"""Writing of an mcap file with the writer of the mcap package: ros2 profile, chunks handed to the system in time."""

from contextlib import suppress
from pathlib import Path
from typing import Literal

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2.metadata import dump_qos_v9

from friction_bags.bag_format import Contents, Topic

Compression = Literal["zstd", "lz4", "none"]
_COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
_UINT32 = 0xFFFFFFFF


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

    def write(self, channel: int, stamp: int, data: bytes, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message.

        Args:
            channel: of add_topic.
            stamp: recording time [ns].
            data: CDR with its encapsulation header.
            sent: time [ns] at which it was published; the recording time where unknown.
            sequence: number given by the publisher, 0 where unknown.
        """
        self._writer.add_message(channel, stamp, data, stamp if sent is None else sent, sequence & _UINT32)
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
