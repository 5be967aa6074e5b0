"""The messages of an mcap file that are compressed and written together, with their index."""

from struct import Struct, pack
from typing import Final

from mcap.opcode import Opcode

_MESSAGE: Final = Struct("<BQHIQQ")
_MESSAGE_FIELDS_SIZE: Final = 22
_MESSAGE_OPCODE: Final = int(Opcode.MESSAGE)
_INDEX: Final = Struct("<BQHI")
_INDEX_FIELDS_SIZE: Final = 6
_UINT32: Final = 0xFFFFFFFF


class McapChunk:
    """Records of a chunk that grows."""

    def __init__(self) -> None:
        """Start empty."""
        self.size = 0
        """Bytes of the records."""
        self.start = 0
        """Earliest stamp [ns]."""
        self.end = 0
        """Latest stamp [ns]."""
        self._parts: list[bytes] = []
        self._index: dict[int, list[int]] = {}

    @property
    def has_messages(self) -> bool:
        """Whether there is a message, not schemas and channels only."""
        return bool(self._index)

    def records(self) -> bytes:
        """Records in their order."""
        return b"".join(self._parts)

    def add(self, record: bytes) -> None:
        """Append a schema or a channel."""
        self._parts.append(record)
        self.size += len(record)

    def add_message(self, channel: int, stamp: int, data: bytes, sent: int, sequence: int) -> None:
        """Append a message, see McapWriter.write."""
        entries = self._index.get(channel)
        if entries is None:
            if not self._index:
                self.start = self.end = stamp
            entries = self._index[channel] = []
        entries.append(stamp)
        entries.append(self.size)
        if stamp > self.end:
            self.end = stamp
        elif stamp < self.start:
            self.start = stamp
        size = _MESSAGE_FIELDS_SIZE + len(data)
        self._parts.append(_MESSAGE.pack(_MESSAGE_OPCODE, size, channel, sequence & _UINT32, stamp, sent))
        self._parts.append(data)
        self.size += _MESSAGE.size + len(data)

    def indexes(self) -> dict[int, bytes]:
        """Return a record for each channel: stamps and positions of its messages."""
        return {
            channel: _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX_FIELDS_SIZE + 8 * len(entries), channel, 8 * len(entries))
            + pack(f"<{len(entries)}Q", *entries)
            for channel, entries in self._index.items()
        }
