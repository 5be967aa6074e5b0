"""Counts the objects of a BLF log, so that one that is cut off is known for what it is.

A BLF file is a header, which states how many objects there are, and objects, most of them in compressed containers; an
object may go on in the next container. Readers of frames skip what they do not know, and end where the file ends.
"""

import struct
import zlib
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from friction_bags.bag_io.bag_format import BagError

_FILE: Final = struct.Struct("<4sL24xL")
"""Signature, size of the header, objects that are stated."""
_OBJECT: Final = struct.Struct("<4sHHLL")
"""Signature, size of its header, version, size, type."""
_METHOD: Final = struct.Struct("<H14x")
"""Of a container: whether it is compressed."""
_CONTAINER, _ZLIB = 10, 2


class Objects(NamedTuple):
    """How many objects a log has."""

    stated: int
    """By its header; 0 where the logger did not come to write it."""
    there: int
    """In the file, containers included."""
    is_whole: bool
    """Whether the file ends with an object."""


def count_objects(path: Path) -> Objects:
    """Count the objects of a log.

    Raises:
        BagError: it is no BLF log, or an object has a size that none can have.
        OSError: it cannot be read.
    """
    with path.open("rb") as stream:
        head = stream.read(_FILE.size)
        if len(head) < _FILE.size or head[:4] != b"LOGG":
            raise BagError(f"{path} cannot be read: it is no BLF log")
        _, size, stated = _FILE.unpack(head)
        stream.seek(size)
        there, rest = 0, b""
        while begin := stream.read(_OBJECT.size):
            found = _object(path, stream, begin)
            if found is None:
                return Objects(stated, there, False)
            there += 1
            if found[0] != _CONTAINER:
                continue
            content = _content(found[1])
            if content is None:
                return Objects(stated, there, False)
            inside, rest = _count_inside(path, rest + content)
            there += inside
        return Objects(stated, there, not rest.strip(b"\0"))


def _object(path: Path, stream: BinaryIO, begin: bytes) -> tuple[int, bytes] | None:
    """Return type and data of an object that begins with these bytes; None where the file ends within it."""
    if len(begin) < _OBJECT.size:
        return None
    signature, _, _, size, kind = _OBJECT.unpack(begin)
    if signature != b"LOBJ" or size < _OBJECT.size:
        raise BagError(f"{path} cannot be read to its end: an object is damaged")
    if size > path.stat().st_size:
        return None
    data = stream.read(size - _OBJECT.size)
    stream.read(size % 4)
    return (kind, data) if len(data) == size - _OBJECT.size else None


def _content(data: bytes) -> bytes | None:
    """Return what is in a container, None where it is damaged."""
    if len(data) < _METHOD.size:
        return None
    if _METHOD.unpack_from(data)[0] != _ZLIB:
        return data[_METHOD.size :]
    try:
        return zlib.decompressobj().decompress(data[_METHOD.size :])
    except zlib.error:
        return None


def _count_inside(path: Path, data: bytes) -> tuple[int, bytes]:
    """Return the number of objects in the data of containers, and the part of one that goes on in the next."""
    count = at = 0
    while (place := data.find(b"LOBJ", at, at + 8)) >= 0 and place + _OBJECT.size <= len(data):
        size = _OBJECT.unpack_from(data, place)[3]
        if size < _OBJECT.size:
            raise BagError(f"{path} cannot be read to its end: it has an object of {size} bytes")
        if place + size > len(data):
            return count, data[place:]
        count, at = count + 1, place + size
    return count, data[at:]
