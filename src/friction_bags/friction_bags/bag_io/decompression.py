"""Decompression that stops at a limit: a file of some kilobytes can claim, or hold, gigabytes of zeros."""

import os
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from rosbags.rosbag2 import storage_mcap

from friction_bags.bag_io.bag_format import BagError

GIB = 1 << 30
VARIABLE = "FRICTION_BAGS_LARGEST_GIB"
"""Environment variable that raises or lowers the limit: the processes of one command share it."""
_PIECE = 1024
"""Bytes after which the size is looked at: zstd makes up to 32 MiB of them."""
_WRITTEN = 1 << 20


def largest() -> int:
    """Return the most [bytes] that one chunk, message or file may take unpacked: 1 GiB, or the value of VARIABLE.

    Raises:
        BagError: VARIABLE is not a positive number.
    """
    text = os.environ.get(VARIABLE, "1")
    try:
        gib = float(text)
    except ValueError:
        gib = 0.0
    if not 0.0 < gib < 1e6:
        raise BagError(f"{VARIABLE} is {text!r}: give the most that a file may take unpacked, in GiB")
    return round(gib * GIB)


def too_large(size: int) -> str:
    """Return why data of a size [bytes] is not unpacked; empty where it is."""
    limit = largest()
    if size <= limit:
        return ""
    return f"{size / GIB:.2f} GiB unpacked, more than {limit / GIB:.3g} GiB: set {VARIABLE} if that is right"


def unpack_message(data: bytes) -> bytes:
    """Return a message that was compressed by itself with zstd.

    Raises:
        BagError: it would be too large.
        zstandard.ZstdError: it is damaged.
    """
    _refuse(zstandard.frame_content_size(data), "message")
    return zstandard.decompress(data)


def unpack_what_is_there(data: bytes, compression: str, size: int) -> bytes | None:
    """Return damaged data as far as it can be decompressed; None where the compression is unknown.

    Args:
        data: compressed data, or the beginning of it.
        compression: zstd, lz4 or empty, as in an mcap chunk.
        size: of all the data unpacked [bytes]; nothing is returned where there is more.
    """
    if compression == "":
        return data
    decompressor: zstandard.ZstdDecompressionObj | lz4.frame.LZ4FrameDecompressor
    if compression == "zstd":
        decompressor = zstandard.ZstdDecompressor(max_window_size=max(size, 1 << 27)).decompressobj()
    elif compression == "lz4":
        decompressor = lz4.frame.LZ4FrameDecompressor()
    else:
        return None
    raw = bytearray()
    try:
        for position in range(0, len(data), _PIECE):
            raw += decompressor.decompress(data[position : position + _PIECE])
            if len(raw) > size:
                return b""
    except (zstandard.ZstdError, RuntimeError, EOFError, ValueError):
        pass
    return bytes(raw)


def unpack_file(packed: Path, to: Path) -> str:
    """Decompress a zstd file as far as possible; return what went wrong, empty where nothing did.

    Raises:
        OSError: a file cannot be read or written.
        BagError: VARIABLE is not a positive number.
    """
    limit, written = largest(), 0
    with packed.open("rb") as source, to.open("wb") as target:
        try:
            for piece in zstandard.ZstdDecompressor().read_to_iter(source, write_size=_WRITTEN):
                written += len(piece)
                if written > limit:
                    return f"decompression stopped: {too_large(written)}"
                target.write(piece)
        except zstandard.ZstdError as error:
            return f"decompression stopped: {error}"
    return ""


def _unpack_zstd(data: bytes, size: int) -> bytes:
    _refuse(max(size, zstandard.frame_content_size(data)))
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)


def _unpack_lz4(data: bytes, size: int) -> bytes:
    _refuse(size)
    raw: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    return raw


def _refuse(size: int, what: str = "chunk") -> None:
    text = too_large(size)
    if text:
        raise BagError(f"a {what} takes {text}")


# rosbags decompresses whatever a chunk claims or holds. It compares the length of what these return with the claim.
storage_mcap.DECOMPRESSORS.update(zstd=_unpack_zstd, lz4=_unpack_lz4)
