"""Recovery of damaged storage files.

What a killed recorder, a cut or a damaged file leaves is read from the beginning of the file, without its index. A
chunk that is damaged or cut off is left out, and the reading goes on after it. What is lost is named.
"""

import os
import shutil
import sqlite3
import struct
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mcap.records import Channel, Chunk, DataEnd, Footer, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2.metadata import parse_qos

from friction_bags.bag_io.bag_format import BagError, Topic, full_type

Recorded = tuple[Topic, int, bytes]
"""Topic, recording stamp [ns], CDR data."""
_SQLITE_MAGIC = b"SQLite format 3\0"
MAGICS = {".mcap": MCAP0_MAGIC, ".db3": _SQLITE_MAGIC}
"""What a storage file begins with, by its suffix."""
_LARGEST_CHUNK = 1 << 30
"""Chunks that claim more [bytes] are damaged."""


class Recovery:
    """The messages of a storage file, in the order of writing. `problems` is complete once `messages` has ended."""

    def __init__(self, path: Path) -> None:
        """Look at the first bytes of the file.

        Raises:
            BagError: the file is empty, or of another kind.
            OSError: the file cannot be opened.
        """
        if path.suffix not in MAGICS:
            raise BagError(f"{path} is neither an .mcap nor a .db3 file")
        magic, self._read = MAGICS[path.suffix], self._of_mcap if path.suffix == ".mcap" else self._of_sqlite
        with path.open("rb") as stream:
            begin = stream.read(len(magic))
        if begin != magic:
            raise BagError(f"{path} is {f'no {path.suffix} file (wrong magic)' if begin else 'empty'}")
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self.topics: dict[int, Topic] = {}
        """Topics of what was read so far, by their number in the file."""
        self.problems: list[str] = []

    def messages(self, start: int = 0) -> Iterator[Recorded]:
        """Yield topic, recording stamp [ns] and data of what was recorded from `start` [ns] on."""
        self.problems.clear()
        return (message for message in self._read() if message[1] >= start)

    def _note(self, problem: str) -> None:
        if (text := f"{self._path}: {problem}") not in self.problems:
            self.problems.append(text)

    def _of_mcap(self) -> Iterator[Recorded]:
        for record in self._records(lambda _: None):
            self._declare(record)  # the summary repeats the declarations of a chunk that may be damaged
        for record in self._records(self._note):
            try:
                if isinstance(record, Chunk) and record.uncompressed_size > _LARGEST_CHUNK:
                    raise ValueError(f"{record.uncompressed_size} bytes are claimed")
                found = breakup_chunk(record, validate_crc=True) if isinstance(record, Chunk) else [record]
            except Exception as error:  # the mcap package passes on what its decompressors and decoders raise
                self._note(f"a damaged chunk of {len(record.data)} bytes is left out ({error or type(error).__name__})")
                continue
            for each in found:
                self._declare(each)
            messages = [each for each in found if isinstance(each, Message)]
            for message in sorted(messages, key=lambda each: each.log_time):
                if message.channel_id in self.topics:
                    yield self.topics[message.channel_id], message.log_time, message.data
                else:
                    self._note(f"messages of channel {message.channel_id} left out: it is not declared, or not CDR")

    def _records(self, note: Callable[[str], None]) -> Iterator[Any]:
        """Yield the records of the file, chunks as such, up to its end or to damage outside of chunks."""
        at, ended, size = len(MCAP0_MAGIC), False, self._path.stat().st_size
        with self._path.open("rb") as stream:
            try:
                for record in StreamReader(stream, emit_chunks=True, record_size_limit=_LARGEST_CHUNK).records:
                    ended |= isinstance(record, DataEnd | Footer)
                    at = stream.tell()
                    yield record
            except Exception as error:  # see _of_mcap
                if not ended:
                    why = f"truncated, or never closed ({error or type(error).__name__})"
                    note(f"the last {size - at} of {size} bytes cannot be read: {why}")

    def _declare(self, record: Any) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel) and record.message_encoding == "cdr" and record.schema_id in self._schemas:
            schema = self._schemas[record.schema_id]
            try:
                qos = tuple(parse_qos(record.metadata.get("offered_qos_profiles", "")))
            except Exception:  # damaged text: rosbags passes on whatever it makes of it
                qos = ()
                self._note(f"topic {record.topic}: its QoS cannot be read")
            definition = schema.data.decode(errors="replace"), schema.encoding
            type_hash = record.metadata.get("topic_type_hash", "")
            self.topics[record.id] = Topic(record.topic, full_type(schema.name), *definition, type_hash, qos)

    def _of_sqlite(self) -> Iterator[Recorded]:
        """Read a copy with its write-ahead log, and of a cut file the whole pages: the rest would read as zeros."""
        with TemporaryDirectory(prefix="friction_bags_") as directory:
            copy = Path(directory, self._path.name)
            shutil.copyfile(self._path, copy)
            if (log := _write_ahead_log(self._path)).exists():
                shutil.copyfile(log, _write_ahead_log(copy))
            if lost := _missing_bytes(self._path):
                self._note(f"truncated: {lost} bytes are missing")
                page_size, _ = _pages(self._path)
                os.truncate(copy, self._path.stat().st_size // page_size * page_size)
            try:
                with closing(sqlite3.connect(copy)) as database:
                    database.execute(
                        "PRAGMA writable_schema = ON"
                    )  # else a file shorter than its header says is refused
                    columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
                    qos_of = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
                    for key, name, kind, qos in database.execute(f"SELECT id, name, type, {qos_of} FROM topics"):
                        self.topics.setdefault(key, Topic(name, full_type(kind), qos=tuple(parse_qos(qos))))
                    query = "SELECT topic_id, timestamp, data FROM messages ORDER BY id"
                    for key, stamp, data in database.execute(query):
                        if not isinstance(stamp, int):
                            self._note(f"a message recorded at {stamp!r} is left out")
                        elif key in self.topics and isinstance(data, bytes):
                            yield self.topics[key], stamp, data
            except sqlite3.DatabaseError as error:
                self._note(f"reading stopped: {error}")


def sqlite_fault(path: Path) -> str:
    """Return why a database is not read as it is; empty where nothing speaks against it."""
    if _missing_bytes(path):
        return "the file is truncated"
    log = _write_ahead_log(path)
    return f"the recorder was killed: {log.name} is read, too" if log.exists() and log.stat().st_size else ""


def _write_ahead_log(path: Path) -> Path:
    return path.with_name(f"{path.name}-wal")


def _missing_bytes(path: Path) -> int:
    """Return by how much a database is shorter than its header states."""
    page_size, count = _pages(path)
    return max(page_size * count - path.stat().st_size, 0)


def _pages(path: Path) -> tuple[int, int]:
    """Return size [bytes] and number of pages by the header of a database; 1 and 0 where there is none."""
    with path.open("rb") as stream:
        header = stream.read(100)
    if len(header) < 100 or not header.startswith(_SQLITE_MAGIC):
        return 1, 0
    (page_size,), (count,) = struct.unpack_from(">H", header, 16), struct.unpack_from(">I", header, 28)
    return (65536 if page_size == 1 else max(page_size, 1)), count
