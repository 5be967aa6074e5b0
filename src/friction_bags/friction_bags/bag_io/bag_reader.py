"""Reading any rosbag2 bag: mcap or sqlite3, compressed or not, whole or damaged."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any, TypeVar, cast

import yaml
import zstandard
from rosbags.interfaces import Connection, ConnectionExtRosbag2, MessageDefinitionFormat
from rosbags.rosbag2 import Reader

from friction_bags.bag_io.bag_format import METADATA_NAME, BagError, Contents, Topic, full_type, read_custom_data
from friction_bags.bag_io.recover import MAGICS, Recorded, Recovery, sqlite_fault

Message = Recorded
Opened = TypeVar("Opened", bound="BagReader")

_ENCODINGS = {
    MessageDefinitionFormat.MSG: "ros2msg",
    MessageDefinitionFormat.IDL: "ros2idl",
    MessageDefinitionFormat.NONE: "",
}
_STORAGES = {".mcap": "mcap", ".db3": "sqlite3"}
_COMPRESSED = ".zstd"
_LATEST = 1 << 63
"""Later than any stamp of a recorder [ns]."""
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


@dataclass
class _Part:
    """A storage file: with an index, or to be recovered where there is no reader."""

    path: Path
    contents: Contents
    reader: Reader | None
    topic_of: dict[int, Topic]


class BagReader:
    """A bag, open for reading.

    What cannot be read is listed in `problems`, on opening and while reading; the rest is read. On damaged files
    rosbags passes on errors of every layer below it, hence the broad `except Exception` around its calls.
    """

    def __init__(self, bag: Path) -> None:
        """Open a bag.

        Args:
            bag: directory, or a single storage file.

        Raises:
            BagError: there is no such bag, or nothing in it can be read.
        """
        self.bag = bag
        self.problems: list[str] = []
        self._parts: list[_Part] = []
        self._unpacked: TemporaryDirectory[str] | None = None
        if not bag.exists():
            raise BagError(f"{bag} does not exist")
        files = self._listed_files() if bag.is_dir() else [bag]
        if not files:
            raise BagError(f"{bag} holds no .mcap or .db3 file")
        for file in files:
            path = self._unpack(file) if file.suffix == _COMPRESSED else self._by_content(file)
            if path is not None and not self._open_indexed(path):
                self._open_damaged(path)
        if not self._parts:
            self.close()
            raise BagError(f"{bag} cannot be read: {'; '.join(self.problems)}")

    @property
    def counts(self) -> dict[Topic, int]:
        """Messages of each topic."""
        counts: dict[Topic, int] = {}
        for part in self._parts:
            for topic, count in part.contents.counts.items():
                counts[topic] = counts.get(topic, 0) + count
        return counts

    @property
    def message_count(self) -> int:
        """Messages of all topics."""
        return sum(part.contents.message_count for part in self._parts)

    @property
    def start(self) -> int:
        """Earliest recording stamp [ns]; 0 in an empty bag."""
        return min((part.contents.start for part in self._parts if part.contents.message_count), default=0)

    @property
    def end(self) -> int:
        """Latest recording stamp [ns]; 0 in an empty bag."""
        return max((part.contents.end for part in self._parts if part.contents.message_count), default=0)

    @property
    def custom_data(self) -> dict[str, str]:
        """Notes that travel with the bag."""
        return read_custom_data(self.bag) if self.bag.is_dir() else {}

    @property
    def storage(self) -> str:
        """Name of the storage: mcap or sqlite3."""
        return storage_of(self._parts[0].path)

    def messages(
        self, topics: Collection[Topic] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]:
        """Yield topic, recording stamp [ns] and CDR data in the order of recording, one file after the other.

        Args:
            topics: only these; None for all.
            start: first stamp [ns].
            stop: stamp [ns] before which to stop.
        """
        wanted = {(topic.name, topic.type): topic for topic in (self.counts if topics is None else topics)}
        for part in self._parts:
            for message in self._part_messages(part, wanted, start or 0):
                if stop is None or message[1] < stop:
                    yield message

    def close(self) -> None:
        """Close the files."""
        for part in self._parts:
            if part.reader is not None:
                part.reader.close()
        self._parts.clear()
        if self._unpacked is not None:
            self._unpacked.cleanup()

    def __enter__(self: Opened) -> Opened:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _listed_files(self) -> list[Path]:
        """Files named by metadata.yaml; those found where it is missing or damaged."""
        path = self.bag / METADATA_NAME
        advice = f"`python3 -m friction_bags reindex {self.bag}` rebuilds it"
        if not path.is_file():
            self.problems.append(f"{self.bag} has no {METADATA_NAME} (recorder killed?): {advice}")
            return storage_files(self.bag)
        try:
            document: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
            names = [PurePath(name).name for name in document["rosbag2_bagfile_information"]["relative_file_paths"]]
        except (OSError, ValueError, yaml.YAMLError, LookupError, TypeError) as error:
            self.problems.append(f"{path} cannot be read ({_said(error)}): {advice}")
            return storage_files(self.bag)
        files = [self.bag / name for name in names]
        self.problems.extend(f"{file} is missing" for file in files if not file.is_file())
        return [file for file in files if file.is_file()]

    def _unpack(self, file: Path) -> Path | None:
        """Decompress a file as far as possible into a temporary directory."""
        unpacked = self._scratch() / file.stem
        try:
            with file.open("rb") as source, unpacked.open("wb") as target:
                zstandard.ZstdDecompressor().copy_stream(source, target)
        except OSError as error:
            self.problems.append(f"{file}: {_said(error)}")
            return None
        except zstandard.ZstdError as error:
            self.problems.append(f"{file}: decompression stopped: {error}")
        return unpacked

    def _by_content(self, file: Path) -> Path:
        """Return a file, under another name where its own hides what it is: rosbags goes by the suffix."""
        if file.suffix in _STORAGES:
            return file
        try:
            with file.open("rb") as stream:
                begin = stream.read(max(map(len, MAGICS.values())))
        except OSError:
            return file  # named where it is opened
        suffix = next((each for each, magic in MAGICS.items() if begin.startswith(magic)), "")
        if not suffix:
            return file
        other = self._scratch() / f"{file.name}{suffix}"
        other.symlink_to(file.absolute())
        return other

    def _scratch(self) -> Path:
        """Directory of what must not be beside the bag."""
        if self._unpacked is None:
            self._unpacked = TemporaryDirectory(prefix="friction_bags_")
        return Path(self._unpacked.name)

    def _part_messages(self, part: _Part, wanted: dict[tuple[str, str], Topic], start: int) -> Iterator[Message]:
        last = start - 1
        if part.reader is not None:
            topics = {
                key: wanted[topic.name, topic.type]
                for key, topic in part.topic_of.items()
                if (topic.name, topic.type) in wanted
            }
            connections = [each for each in part.reader.connections if each.id in topics]
            if not connections:
                return
            try:
                for connection, stamp, data in part.reader.messages(connections, start or None):
                    if self._is_stamp(part, stamp):
                        yield topics[connection.id], stamp, _plain(data)
                        last = stamp
                return
            except Exception as error:
                self.problems.append(f"{part.path}: {_said(error)}; going on behind the damage")
        try:
            recovery = Recovery(part.path)
            for topic, stamp, data in recovery.messages(last + 1):
                named = wanted.get((topic.name, topic.type))
                if named is not None and self._is_stamp(part, stamp):
                    yield named, stamp, _plain(data)
        except Exception as error:
            self._note([_said(error)])
        else:
            self._note(recovery.problems)

    def _is_stamp(self, part: _Part, stamp: Any) -> bool:
        """Whether a recording stamp [ns] can be one; sqlite keeps whatever a damaged row holds."""
        if isinstance(stamp, int) and 0 <= stamp < _LATEST:
            return True
        self._note([f"{part.path}: a message recorded at {stamp!r} is left out"])
        return False

    def _note(self, problems: list[str]) -> None:
        self.problems.extend(problem for problem in problems if problem not in self.problems)

    def _open_indexed(self, file: Path) -> bool:
        try:
            if file.suffix == ".db3" and (fault := sqlite_fault(file)):
                raise BagError(fault)
            reader = Reader(file)
            reader.open()
        except Exception as error:
            self.problems.append(f"{file}: {_said(error)}")
            return False
        topic_of = {connection.id: _topic(connection) for connection in reader.connections}
        counts: dict[Topic, int] = {}
        for connection in reader.connections:
            topic = topic_of[connection.id]
            counts[topic] = counts.get(topic, 0) + connection.msgcount
        empty = not reader.message_count
        contents = Contents(file.name, counts, 0 if empty else reader.start_time, 0 if empty else reader.end_time - 1)
        self._parts.append(_Part(file, contents, reader, topic_of))
        return True

    def _open_damaged(self, file: Path) -> None:
        counts: dict[Topic, int] = {}
        stamps: list[int] = []
        try:
            recovery = Recovery(file)
            for topic, stamp, _ in recovery.messages():
                counts[topic] = counts.get(topic, 0) + 1
                stamps = [min(stamp, *stamps), max(stamp, *stamps)] if stamps else [stamp, stamp]
        except Exception as error:
            self._note([_said(error)])
            return
        self._note(recovery.problems)
        counts = {**dict.fromkeys(recovery.topics.values(), 0), **counts}
        begin, end = stamps or (0, 0)
        self._parts.append(_Part(file, Contents(file.name, counts, begin, end), None, {}))


def storage_files(bag: Path) -> list[Path]:
    """Storage files of a bag's directory, in the order of their numbers."""
    files = [path for path in bag.iterdir() if Path(path.name.removesuffix(_COMPRESSED)).suffix in _STORAGES]
    return sorted(files, key=lambda path: (len(path.name), path.name))


def storage_of(file: Path) -> str:
    """Return the name of a file's storage in rosbag2."""
    return _STORAGES[file.suffix]


def _topic(connection: Connection) -> Topic:
    ext = cast("ConnectionExtRosbag2", connection.ext)
    return Topic(
        connection.topic,
        full_type(connection.msgtype),
        connection.msgdef.data,
        _ENCODINGS[connection.msgdef.format],
        connection.digest or "",
        tuple(ext.offered_qos_profiles),
    )


def _plain(data: bytes) -> bytes:
    """Return the CDR of a message, decompressed if the bag compresses messages one by one."""
    return zstandard.decompress(data) if data[:4] == _ZSTD_MAGIC else data


def _said(error: BaseException) -> str:
    return str(error) or type(error).__name__
