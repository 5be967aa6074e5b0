"""Writing of an mcap file: ros2 profile, chunks written in time.

Schemas, channels and summary are records of the mcap package. Its writer takes 5 µs per message, which is more than an
estimator takes for it, hence the chunks of our own.
"""

import zlib
from contextlib import suppress
from pathlib import Path
from struct import Struct
from typing import Final, Literal

import lz4.frame  # type: ignore[import-untyped]
import yaml
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2.metadata import dump_qos_v9

from friction_bags.bag_io.bag_format import Contents, Topic
from friction_bags.bag_io.mcap_chunk import McapChunk

Compression = Literal["zstd", "lz4", "none"]
_FOOTER = Struct("<BQQQ")
_FOOTER_FIELDS_SIZE: Final = 20


class McapWriter:
    """One mcap file of CDR messages, ros2 profile: what was flushed survives a kill of the process (no fsync)."""

    def __init__(self, path: Path, *, compression: Compression = "zstd", chunk_size: int = 1 << 20) -> None:
        """Create the file.

        Args:
            path: path of the file, which must not exist.
            compression: compression of each chunk.
            chunk_size: size at which a chunk is closed [bytes].

        Raises:
            OSError: the file exists or cannot be made.
        """
        self._file = path.open("xb")
        self._name = path.name
        self._compression = "" if compression == "none" else compression
        self._compressor = zstandard.ZstdCompressor()
        self._chunk_size = chunk_size
        self._chunk = McapChunk()
        self._chunk_indexes: list[bytes] = []
        self._schemas: dict[tuple[str, str], Schema] = {}
        self._channels: dict[Topic, Channel] = {}
        self._counts: dict[int, int] = {}
        self._start: int | None = None
        self._end = 0
        self._file.write(MCAP0_MAGIC + _encoded(Header(profile="ros2", library="friction_bags")))

    def add_topic(self, topic: Topic) -> int:
        """Declare a topic, once; return its channel."""
        known = self._channels.get(topic)
        if known is not None:
            return known.id
        key = (topic.type, topic.definition)
        if key not in self._schemas:
            schema = Schema(
                id=len(self._schemas) + 1,
                name=topic.type,
                encoding=topic.definition_encoding,
                data=topic.definition.encode(),
            )
            self._schemas[key] = schema
            self._chunk.add(_encoded(schema))
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic.name,
            message_encoding="cdr",
            schema_id=self._schemas[key].id,
            metadata={
                "offered_qos_profiles": yaml.safe_dump(dump_qos_v9(list(topic.qos)), sort_keys=False).strip(),
                "topic_type_hash": topic.type_hash,
            },
        )
        self._channels[topic] = channel
        self._counts[channel.id] = 0
        self._chunk.add(_encoded(channel))
        return channel.id

    def write(self, channel: int, stamp: int, data: bytes, sent: int | None = None, sequence: int = 0) -> None:
        """Append a message.

        Args:
            channel: channel, from add_topic.
            stamp: recording time [ns].
            data: CDR with its encapsulation header.
            sent: time [ns] at which it was published; the recording time where unknown.
            sequence: number given by the publisher, 0 where unknown.
        """
        self._chunk.add_message(channel, stamp, data, stamp if sent is None else sent, sequence)
        self._counts[channel] += 1
        if self._chunk.size >= self._chunk_size:
            self._close_chunk()

    def flush(self) -> None:
        """Close the present chunk and hand everything to the operating system."""
        self._close_chunk()
        self._file.flush()

    def abandon(self) -> None:
        """Close the file as it is, after an error."""
        with suppress(OSError):
            self._file.close()

    def finish(self) -> Contents:
        """Write index and footer, close, and return the contents of the file."""
        try:
            self._close_chunk()
            self._file.write(_encoded(DataEnd(data_section_crc=0)))
            self._write_summary()
        finally:
            self._file.close()
        counts = {topic: self._counts[channel.id] for topic, channel in self._channels.items()}
        return Contents(self._name, counts, self._start or 0, self._end)

    def _close_chunk(self) -> None:
        chunk = self._chunk
        if not chunk.has_messages:
            return
        records = chunk.records()
        data = self._compressed(records)
        record = _encoded(
            Chunk(
                compression=self._compression,
                data=data,
                message_start_time=chunk.start,
                message_end_time=chunk.end,
                uncompressed_crc=zlib.crc32(records),
                uncompressed_size=len(records),
            )
        )
        begin = position = self._file.tell()
        position += self._file.write(record)
        indexes_begin = position
        offsets: dict[int, int] = {}
        for channel, index in chunk.indexes().items():
            offsets[channel] = position
            position += self._file.write(index)
        self._chunk_indexes.append(
            _encoded(
                ChunkIndex(
                    message_start_time=chunk.start,
                    message_end_time=chunk.end,
                    chunk_start_offset=begin,
                    chunk_length=len(record),
                    message_index_offsets=offsets,
                    message_index_length=position - indexes_begin,
                    compression=self._compression,
                    compressed_size=len(data),
                    uncompressed_size=len(records),
                )
            )
        )
        self._start = chunk.start if self._start is None else min(self._start, chunk.start)
        self._end = max(self._end, chunk.end)
        self._chunk = McapChunk()

    def _compressed(self, raw: bytes) -> bytes:
        if self._compression == "zstd":
            return self._compressor.compress(raw)
        if self._compression == "lz4":
            return bytes(lz4.frame.compress(raw))
        return raw

    def _write_summary(self) -> None:
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunk_indexes),
            message_count=sum(self._counts.values()),
            message_end_time=self._end,
            message_start_time=self._start or 0,
            metadata_count=0,
            schema_count=len(self._schemas),
        )
        groups = {
            Opcode.SCHEMA: [_encoded(schema) for schema in self._schemas.values()],
            Opcode.CHANNEL: [_encoded(channel) for channel in self._channels.values()],
            Opcode.STATISTICS: [_encoded(statistics)],
            Opcode.CHUNK_INDEX: self._chunk_indexes,
        }
        begin = self._file.tell()
        summary = offsets = b""
        for opcode, records in groups.items():
            group = b"".join(records)
            if group:
                offsets += _encoded(
                    SummaryOffset(group_opcode=opcode, group_start=begin + len(summary), group_length=len(group))
                )
            summary += group
        offset_start = begin + len(summary)
        summary += offsets
        head = _FOOTER.pack(Opcode.FOOTER, _FOOTER_FIELDS_SIZE, begin, offset_start)
        checksum = zlib.crc32(summary + head)
        footer = Footer(summary_start=begin, summary_offset_start=offset_start, summary_crc=checksum)
        self._file.write(summary + _encoded(footer) + MCAP0_MAGIC)


def _encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
