"""Reading what can be read of a sqlite3 bag file that is truncated or damaged."""

import sqlite3
from collections.abc import Iterator
from pathlib import Path

from rosbags.rosbag2.metadata import parse_qos

from friction_bags.bag_format import BagError, Topic


class SqliteSalvage:
    """One pass over a damaged file, in the order of writing, up to the damage."""

    def __init__(self, path: Path) -> None:
        """Read the topics.

        Raises:
            BagError: the file is empty, is no database, or its table of topics cannot be read.
        """
        if path.stat().st_size == 0:
            raise BagError(f"{path} is empty")
        self._path = path
        self.problems: list[str] = []
        try:
            with self._connect() as database:
                columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
                optional = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
                rows = database.execute(f"SELECT id, name, type, {optional} FROM topics").fetchall()
        except sqlite3.DatabaseError as error:
            raise BagError(f"{path} cannot be read: {error}") from error
        self._topics = {key: Topic(name, kind, qos=tuple(parse_qos(qos))) for key, name, kind, qos in rows}

    @property
    def topics(self) -> list[Topic]:
        """Topics of the file."""
        return list(self._topics.values())

    def messages(self, start: int = 0) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, recording stamp [ns] and data; then `problems` says where it had to stop.

        Args:
            start: leave out what was recorded before this stamp [ns].
        """
        self.problems.clear()
        database = self._connect()
        try:
            query = "SELECT topic_id, timestamp, data FROM messages WHERE timestamp >= ? ORDER BY id"
            for key, stamp, data in database.execute(query, (start,)):
                if key in self._topics:
                    yield self._topics[key], stamp, data
        except sqlite3.DatabaseError as error:
            self.problems.append(f"{self._path}: reading stopped: {error}")
        finally:
            database.close()

    def _connect(self) -> sqlite3.Connection:
        return sqlite3.connect(f"{self._path.resolve().as_uri()}?immutable=1", uri=True)
