"""Reading what can be read of an mcap file that is truncated or damaged, or was never closed.

The file is read from its beginning, record by record, without its index. A chunk with a wrong checksum is left out as a
whole; the complete messages of a chunk that is cut off are kept.
"""

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from mcap.writer import MCAP0_MAGIC
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import parse_qos

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.decompression import too_large, unpack_what_is_there

_RECORD_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQI")
_LENGTH_32 = struct.Struct("<I")
_LENGTH_64 = struct.Struct("<Q")
_MESSAGE_HEAD = struct.Struct("<HIQQ")

Message = tuple[Topic, int, bytes]


class McapSalvage:
    """One pass over a damaged file. What was lost is in `problems` once `messages` has ended."""

    def __init__(self, path: Path) -> None:
        """Read the beginning of the file.

        Raises:
            BagError: the file is empty or not an mcap file.
            OSError: the file cannot be opened.
        """
        with path.open("rb") as stream:
            magic = stream.read(len(MCAP0_MAGIC))
        if not magic:
            raise BagError(f"{path} is empty")
        if magic != MCAP0_MAGIC:
            raise BagError(f"{path} is no mcap file (wrong magic)")
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._topics: dict[int, Topic] = {}
        self.problems: list[str] = []
        self._read_declarations()

    @property
    def topics(self) -> list[Topic]:
        """Topics declared in what was read so far."""
        return list(self._topics.values())

    def messages(self, start: int = 0) -> Iterator[Message]:
        """Yield topic, recording stamp [ns] and data, in the order of the file, within a chunk in that of the stamps.

        Args:
            start: leave out what was recorded before this stamp [ns].
        """
        self.problems.clear()
        size = self._path.stat().st_size
        with self._path.open("rb") as stream:
            stream.seek(len(MCAP0_MAGIC))
            while True:
                offset = stream.tell()
                head = stream.read(_RECORD_HEAD.size)
                if len(head) < _RECORD_HEAD.size:
                    self._end_missing(offset)
                    return
                opcode, length = _RECORD_HEAD.unpack(head)
                complete = stream.tell() + length <= size
                if opcode in (Opcode.FOOTER, Opcode.DATA_END) and complete:
                    return
                if opcode == Opcode.CHUNK:
                    yield from self._chunk(stream, min(length, size - stream.tell()), offset, start)
                elif not complete:
                    self._end_missing(offset)
                    return
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                    message = self._record(opcode, stream.read(length))
                    if message is not None and message[1] >= start:
                        yield message
                else:
                    stream.seek(length, 1)

    def _read_declarations(self) -> None:
        """Take the declarations outside of chunks: the summary at the end repeats those of a damaged chunk."""
        size = self._path.stat().st_size
        with self._path.open("rb") as stream:
            stream.seek(len(MCAP0_MAGIC))
            while len(head := stream.read(_RECORD_HEAD.size)) == _RECORD_HEAD.size:
                opcode, length = _RECORD_HEAD.unpack(head)
                if stream.tell() + length > size:
                    return
                if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._record(opcode, stream.read(length))
                else:
                    stream.seek(length, 1)

    def _end_missing(self, offset: int) -> None:
        self.problems.append(f"{self._path}: ends within a record at byte {offset}: truncated, or never closed")

    def _chunk(self, stream: BinaryIO, length: int, offset: int, start: int) -> Iterator[Message]:
        """Read a chunk of which `length` bytes are in the file; leave the stream at its end."""
        payload = stream.read(length)
        try:
            _, end, raw_size, checksum = _CHUNK_HEAD.unpack_from(payload, 0)
            position = _CHUNK_HEAD.size
            (name_length,) = _LENGTH_32.unpack_from(payload, position)
            compression = payload[position + 4 : position + 4 + name_length].decode()
            position += 4 + name_length
            (stored,) = _LENGTH_64.unpack_from(payload, position)
        except (struct.error, UnicodeDecodeError):
            self._end_missing(offset)
            return
        data = payload[position + 8 : position + 8 + stored]
        whole = len(data) == stored
        if whole and end < start:
            return
        text = too_large(raw_size)
        if text:
            self.problems.append(f"{self._path}: chunk at byte {offset} left out: {text}")
            return
        raw = unpack_what_is_there(data, compression, raw_size)
        if raw is None:
            self.problems.append(f"{self._path}: chunk at byte {offset} left out: unknown compression {compression!r}")
            return
        if whole and (len(raw) != raw_size or (checksum and zlib.crc32(raw) != checksum)):
            self.problems.append(f"{self._path}: chunk at byte {offset} left out: its data is damaged")
            return
        if not whole:
            self.problems.append(f"{self._path}: the chunk at byte {offset} is cut off: its complete messages are kept")
        found = [message for message in self._chunk_messages(raw) if message[1] >= start]
        yield from sorted(found, key=lambda message: message[1])

    def _chunk_messages(self, raw: bytes) -> Iterator[Message]:
        position = 0
        while position + _RECORD_HEAD.size <= len(raw):
            opcode, length = _RECORD_HEAD.unpack_from(raw, position)
            position += _RECORD_HEAD.size
            if opcode == 0 or position + length > len(raw):  # no record is numbered 0: these are zeros
                return
            message = self._record(opcode, raw[position : position + length])
            if message is not None:
                yield message
            position += length

    def _record(self, opcode: int, payload: bytes) -> Message | None:
        """Take a schema or a channel, or return a message."""
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(payload)))
                self._schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                self._add_topic(Channel.read(ReadDataStream(BytesIO(payload))))
            elif opcode == Opcode.MESSAGE:
                channel, _, stamp, _ = _MESSAGE_HEAD.unpack_from(payload, 0)
                if channel in self._topics:
                    return self._topics[channel], stamp, payload[_MESSAGE_HEAD.size :]
                self._note(f"{self._path}: messages of channel {channel} left out: its declaration is lost")
        except (struct.error, ValueError, EndOfFile) as error:
            self._note(f"{self._path}: a damaged record was left out ({error or type(error).__name__})")
        return None

    def _add_topic(self, channel: Channel) -> None:
        schema = self._schemas.get(channel.schema_id)
        if schema is None or channel.message_encoding != "cdr":
            self._note(f"{self._path}: topic {channel.topic} left out: no message type, or not CDR")
            return
        self._topics[channel.id] = Topic(
            channel.topic,
            schema.name,
            schema.data.decode(),
            schema.encoding,
            channel.metadata.get("topic_type_hash", ""),
            self._qos(channel),
        )

    def _qos(self, channel: Channel) -> tuple[Qos, ...]:
        try:
            return tuple(parse_qos(channel.metadata.get("offered_qos_profiles", "")))
        except Exception as error:  # damaged text: rosbags passes on whatever it makes of it
            self._note(f"{self._path}: topic {channel.topic}: its QoS is left out ({error or type(error).__name__})")
            return ()

    def _note(self, problem: str) -> None:
        if problem not in self.problems:
            self.problems.append(problem)
