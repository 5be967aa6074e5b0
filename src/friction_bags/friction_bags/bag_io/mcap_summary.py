"""Validation of the summary at the end of an mcap file."""

import struct
import zlib
from collections.abc import Iterator
from heapq import heappop, heappush
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import ChunkIndex

from friction_bags.bag_io.decompression import too_large

_HEAD = struct.Struct("<BQ")
_FOOTER = struct.Struct("<BQQQI8s")


def summary_fault(path: Path) -> str:
    """Return why a file is not read by its summary; empty where it has none or nothing speaks against it.

    Raises:
        OSError: the file cannot be read.
        BagError: the limit on what is unpacked is not a number.
    """
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        if size < _FOOTER.size:
            return ""
        stream.seek(size - _FOOTER.size)
        end = stream.read()
        opcode, _, begin, _, checksum, _ = _FOOTER.unpack(end)
        if opcode != Opcode.FOOTER or not 0 < begin <= size - _FOOTER.size:
            return ""
        stream.seek(begin)
        summary = stream.read(size - _FOOTER.size - begin)
    if checksum and zlib.crc32(summary + end[: _HEAD.size + 16]) != checksum:
        return "its summary is damaged"
    try:
        text = too_large(_largest_at_once(_chunks(summary)))
    except (struct.error, ValueError, EndOfFile) as error:
        return f"its summary is damaged ({error or type(error).__name__})"
    return f"chunks that are read at the same time take {text}" if text else ""


def _chunks(summary: bytes) -> Iterator[ChunkIndex]:
    position = 0
    while position + _HEAD.size <= len(summary):
        opcode, length = _HEAD.unpack_from(summary, position)
        position += _HEAD.size
        if opcode == Opcode.CHUNK_INDEX:
            yield ChunkIndex.read(ReadDataStream(BytesIO(summary[position : position + length])))
        position += length


def _largest_at_once(chunks: Iterator[ChunkIndex]) -> int:
    """Return the most [bytes] of chunks that are read in the order of their stamps, each held to its last stamp."""
    held: list[tuple[int, int]] = []
    total = most = 0
    for chunk in sorted(chunks, key=lambda each: each.message_start_time):
        while held and held[0][0] < chunk.message_start_time:
            total -= heappop(held)[1]
        heappush(held, (chunk.message_end_time, chunk.uncompressed_size))
        total += chunk.uncompressed_size
        most = max(most, total)
    return most
