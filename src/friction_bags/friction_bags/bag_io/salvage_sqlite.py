"""Reading what can be read of a sqlite3 bag file that is truncated or damaged."""

import shutil
import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from rosbags.rosbag2.metadata import parse_qos

from friction_bags.bag_io.bag_format import BagError, Topic

_MAGIC = b"SQLite format 3\0"
_PAGE_SIZE_AT = 16
_PAGE_COUNT_AT = 28


class SqliteSalvage:
    """One pass over a damaged file, in the order of writing, up to the damage.

    Only whole pages of a truncated file are read: sqlite would take the missing part of a page for zeros.
    """

    def __init__(self, path: Path) -> None:
        """Read the topics.

        Raises:
            BagError: the file is empty, is not a database, or its table of topics cannot be read.
            OSError: the file cannot be read.
        """
        with path.open("rb") as stream:
            magic = stream.read(len(_MAGIC))
        if not magic:
            raise BagError(f"{path} is empty")
        if magic != _MAGIC:
            raise BagError(f"{path} is not a database (wrong magic)")
        self._path = path
        self._copy: TemporaryDirectory[str] | None = None
        self._readable = path
        self.problems: list[str] = []
        if is_truncated(path):
            self._copy_whole_pages()
        try:
            database = self._connect()
            columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
            optional = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
            rows = database.execute(f"SELECT id, name, type, {optional} FROM topics").fetchall()
            database.close()
        except sqlite3.DatabaseError as error:
            raise BagError(f"{path} cannot be read: {error}") from error
        self._topics = {key: Topic(name, kind, qos=tuple(parse_qos(qos))) for key, name, kind, qos in rows}

    @property
    def topics(self) -> list[Topic]:
        """Topics of the file."""
        return list(self._topics.values())

    def messages(self, start: int = 0) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, recording stamp [ns] and data; afterwards `problems` holds where reading had to stop.

        Args:
            start: leave out what was recorded before this stamp [ns].
        """
        self.problems.clear()
        database = self._connect()
        try:
            query = "SELECT topic_id, timestamp, data FROM messages WHERE timestamp >= ? ORDER BY id"
            for key, stamp, data in database.execute(query, (start,)):
                if key in self._topics and isinstance(data, bytes):
                    yield self._topics[key], stamp, data
        except sqlite3.DatabaseError as error:
            self.problems.append(f"{self._path}: reading stopped: {error}")
        finally:
            database.close()

    def _copy_whole_pages(self) -> None:
        self._copy = TemporaryDirectory(prefix="friction_bags_")
        self._readable = Path(self._copy.name, self._path.name)
        shutil.copyfile(self._path, self._readable)
        page_size, _ = _pages(self._path)
        with self._readable.open("r+b") as stream:
            stream.truncate(self._path.stat().st_size // page_size * page_size)

    def _connect(self) -> sqlite3.Connection:
        database = sqlite3.connect(f"{self._readable.resolve().as_uri()}?immutable=1", uri=True)
        database.execute("PRAGMA writable_schema = ON")  # else sqlite refuses a file shorter than its header states
        return database


def is_truncated(path: Path) -> bool:
    """Whether a database is shorter than its header states."""
    page_size, count = _pages(path)
    return path.stat().st_size < page_size * count


def _pages(path: Path) -> tuple[int, int]:
    """Return page size in bytes and number of pages in the header (1 and 0 where there is none)."""
    with path.open("rb") as stream:
        header = stream.read(100)
    if len(header) < 100 or not header.startswith(_MAGIC):
        return 1, 0
    (page_size,) = struct.unpack_from(">H", header, _PAGE_SIZE_AT)
    (count,) = struct.unpack_from(">I", header, _PAGE_COUNT_AT)
    return (65536 if page_size == 1 else max(page_size, 1)), count
