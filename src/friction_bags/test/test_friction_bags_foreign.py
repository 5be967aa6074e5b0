import os
from pathlib import Path

import mcap.writer
import pytest
from rosbags.interfaces import Connection
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader

DATA = Path(os.environ.get("FRICTION_DATA", Path(__file__).parents[4] / "shared" / "data"))
BAGS = DATA / "foreign_bags"
needs_foreign_bags = pytest.mark.skipif(not BAGS.is_dir(), reason=f"{BAGS} is absent (set FRICTION_DATA)")


def contents(bag: Path) -> list[tuple[str, str, int, bytes]]:
    with BagReader(bag) as reader:
        found = [(topic.name, topic.type, stamp, data) for topic, stamp, data in reader.messages()]
        assert reader.problems == []
        assert reader.message_count == len(found)
        return found


@needs_foreign_bags
def test_the_same_recording_in_both_storages_reads_the_same() -> None:
    mcap = contents(BAGS / "talker_mcap")
    assert len(mcap) == 20
    assert mcap == contents(BAGS / "talker_sqlite3")
    texts = [data for name, _, _, data in mcap if name == "/topic"]
    assert [b"Hello, world!" in text for text in texts] == [True] * 10


@needs_foreign_bags
def test_messages_of_types_that_are_not_installed_are_read_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    found = contents(BAGS / "cdr_test_mcap")
    assert [name for name, _, _, _ in found].count("/array_topic") == 4
    assert {kind for _, kind, _, _ in found} == {"test_msgs/msg/Arrays", "test_msgs/msg/BasicTypes"}
    assert main(["info", str(BAGS / "cdr_test_mcap")]) == 0
    assert "test_msgs/msg/BasicTypes" in capsys.readouterr().out


@needs_foreign_bags
@pytest.mark.parametrize("name", ["talker_mcap/talker.mcap", "talker_sqlite3/talker.db3"])
def test_a_single_file_opens_without_its_directory(name: str) -> None:
    assert len(contents(BAGS / name)) == 20


@needs_foreign_bags
@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("mode", list(CompressionMode))
def test_every_compression_reads_the_same(tmp_path: Path, storage: StoragePlugin, mode: CompressionMode) -> None:
    if storage == StoragePlugin.SQLITE3 and mode == CompressionMode.STORAGE:
        pytest.skip("sqlite3 has no compression of its own")
    copy = tmp_path / "bag"
    writer = Writer(copy, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with Reader(BAGS / "talker_mcap" / "talker.mcap") as reader, writer:
        connections: dict[int, Connection] = {}
        for each in reader.connections:
            if each.msgcount:
                connections[each.id] = writer.add_connection(
                    each.topic, each.msgtype, msgdef=each.msgdef.data, rihs01="RIHS01_0"
                )
        for connection, stamp, data in reader.messages():
            writer.write(connections[connection.id], stamp, data)
    assert contents(copy) == contents(BAGS / "talker_mcap")


@needs_foreign_bags
def test_part_of_a_bag_is_read_by_topic_and_time() -> None:
    everything = contents(BAGS / "talker_mcap")
    with BagReader(BAGS / "talker_mcap") as reader:
        (topic,) = [topic for topic in reader.counts if topic.name == "/topic"]
        stamps = [stamp for name, _, stamp, _ in everything if name == "/topic"]
        found = [stamp for _, stamp, _ in reader.messages([topic], start=stamps[2], stop=stamps[7])]
    assert found == stamps[2:7]


def two_messages(path: Path, kind: str) -> Path:
    """An mcap file whose type has this name and whose first message was recorded at 0."""
    with path.open("wb") as stream:
        writer = mcap.writer.Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema(kind, "ros2msg", b"string data\n")
        channel = writer.register_channel("/text", "cdr", schema)
        for stamp in (0, 10**9):
            writer.add_message(channel, stamp, b"\0\1\0\0\2\0\0\0a\0\0\0", stamp)
        writer.finish()
    return path


@pytest.mark.parametrize("kind", ["std_msgs/msg/String", "std_msgs/String"])
@pytest.mark.parametrize("name", ["bag.mcap", "bag.bin", "bag"])
def test_a_file_is_read_whatever_its_name_is_and_the_name_of_its_types(tmp_path: Path, name: str, kind: str) -> None:
    found = contents(two_messages(tmp_path / name, kind))
    assert [(topic, of_type, stamp) for topic, of_type, stamp, _ in found] == [
        ("/text", "std_msgs/msg/String", 0),
        ("/text", "std_msgs/msg/String", 10**9),
    ]
