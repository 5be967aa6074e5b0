import shutil
import sqlite3
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter, Compression
from friction_bags.bag_io.reindex import reindex

COUNT = 400
CHUNK = 50
MESSAGE = b"\0\1\0\0" + bytes(range(60))
TOPICS = [Topic(f"/t{index}", "std_msgs/msg/String", "string data\n", "ros2msg") for index in range(2)]


def write_bag(bag: Path, compression: Compression = "zstd") -> list[tuple[str, int, bytes]]:
    written = []
    with BagWriter(bag, compression=compression) as writer:
        for stamp in range(1, COUNT + 1):
            topic = TOPICS[stamp % 2]
            data = MESSAGE + stamp.to_bytes(4, "little")
            writer.write(writer.add_topic(topic), stamp, data)
            written.append((topic.name, stamp, data))
            if stamp % CHUNK == 0:
                writer.flush()
    return written


def read(bag: Path) -> tuple[list[tuple[str, int, bytes]], list[str]]:
    with BagReader(bag) as reader:
        found = [(topic.name, stamp, data) for topic, stamp, data in reader.messages()]
        return found, list(reader.problems)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[Compression, tuple[Path, list[tuple[str, int, bytes]]]]:
    directory = tmp_path_factory.mktemp("whole")
    kinds: tuple[Compression, ...] = ("zstd", "lz4", "none")
    return {kind: (directory / kind, write_bag(directory / kind, kind)) for kind in kinds}


def damaged_copy(bag: Path, data: bytes, directory: Path) -> Path:
    """Copy of a bag without metadata.yaml and with another content of its file."""
    copy = directory / bag.name
    shutil.rmtree(copy, ignore_errors=True)
    copy.mkdir()
    (copy / f"{bag.name}_0.mcap").write_bytes(data)
    return copy


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(["zstd", "lz4", "none"]), part=st.floats(0.0, 1.0, exclude_max=True))
def test_of_a_file_truncated_anywhere_a_beginning_is_read_and_reindex_makes_it_whole(
    bags: dict, tmp_path_factory: pytest.TempPathFactory, kind: str, part: float
) -> None:
    bag, written = bags[kind]
    whole = (bag / f"{kind}_0.mcap").read_bytes()
    length = int(part * len(whole))
    copy = damaged_copy(bag, whole[:length], tmp_path_factory.getbasetemp())
    try:
        found, problems = read(copy)
    except BagError as error:
        assert str(copy) in str(error)
        assert length < 8, "the magic is there, so the file can be opened"
        return
    assert found == written[: len(found)]
    assert problems
    if kind == "none":
        ends = [whole.index(data) + len(data) for _, _, data in written[CHUNK - 1 :: CHUNK]]
        assert len(found) == CHUNK * sum(end <= length for end in ends), "every complete chunk"
    reindex(copy)
    again, problems = read(copy)
    assert again == found
    assert problems == []
    with Reader(copy) as reader:
        assert reader.message_count == len(found)


def test_all_flushed_chunks_of_a_file_without_end_are_read(bags: dict, tmp_path: Path) -> None:
    bag, written = bags["zstd"]
    whole = (bag / "zstd_0.mcap").read_bytes()
    data_end = whole.rindex(b"\x0f\x04\0\0\0\0\0\0\0")
    found, _ = read(damaged_copy(bag, whole[:data_end], tmp_path))
    assert found == written


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(["zstd", "lz4", "none"]), position=st.integers(8, 10**9), flip=st.integers(1, 255))
def test_a_changed_byte_never_gives_a_message_that_was_not_written(
    bags: dict, tmp_path_factory: pytest.TempPathFactory, kind: str, position: int, flip: int
) -> None:
    bag, written = bags[kind]
    data = bytearray((bag / f"{kind}_0.mcap").read_bytes())
    data[position % len(data)] ^= flip
    copy = damaged_copy(bag, bytes(data), tmp_path_factory.getbasetemp())
    try:
        found, _ = read(copy)
    except BagError as error:
        assert str(copy) in str(error)
        return
    if {stamp for _, stamp, _ in found} <= {stamp for _, stamp, _ in written}:
        assert {data for _, _, data in found} <= {data for _, _, data in written}


def test_a_damaged_chunk_is_left_out_and_those_behind_it_are_read(bags: dict, tmp_path: Path) -> None:
    bag, written = bags["none"]
    data = bytearray((bag / "none_0.mcap").read_bytes())
    data[data.index(MESSAGE + (120).to_bytes(4, "little")) + 30] ^= 255
    found, problems = read(damaged_copy(bag, bytes(data), tmp_path))
    assert found == written[:100] + written[150:]
    assert any("damaged" in problem for problem in problems)


def test_a_damaged_first_chunk_does_not_take_the_declarations_with_it(bags: dict, tmp_path: Path) -> None:
    bag, written = bags["none"]
    data = bytearray((bag / "none_0.mcap").read_bytes())
    data[data.index(b"string data")] ^= 255
    found, _ = read(damaged_copy(bag, bytes(data), tmp_path))
    assert found == written[50:]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("bag.mcap", b"", "empty"),
        ("bag.mcap", b"hello, this is no bag at all", "magic"),
        ("bag.db3", b"", "empty"),
        ("bag.db3", b"hello, this is no bag at all" * 100, "magic"),
        ("bag.txt", b"hello", "neither"),
    ],
)
def test_a_file_that_is_no_bag_is_refused_by_name_and_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, content: bytes, said: str
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    assert main(["info", str(file)]) == 2
    error = capsys.readouterr().err
    assert str(file) in error
    assert said in error


def test_a_missing_bag_and_an_empty_directory_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match="does not exist"):
        BagReader(tmp_path / "nothing")
    with pytest.raises(BagError, match=r"no \.mcap or \.db3"):
        BagReader(tmp_path)
    with pytest.raises(BagError, match=r"neither \.mcap nor \.db3"):
        reindex(tmp_path)


@pytest.mark.parametrize("text", ["", "}{", "rosbag2_bagfile_information: 3", "a: [", "\x00"])
def test_damaged_metadata_does_not_keep_the_messages_from_being_read(bags: dict, tmp_path: Path, text: str) -> None:
    bag, written = bags["zstd"]
    copy = damaged_copy(bag, (bag / "zstd_0.mcap").read_bytes(), tmp_path)
    (copy / "metadata.yaml").write_text(text)
    found, problems = read(copy)
    assert found == written
    assert any("metadata.yaml" in problem for problem in problems)


def test_a_file_that_metadata_names_and_is_not_there_is_named(bags: dict, tmp_path: Path) -> None:
    bag, _ = bags["zstd"]
    shutil.copytree(bag, tmp_path / "bag")
    metadata = tmp_path / "bag" / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("- zstd_0.mcap", "- zstd_0.mcap\n  - zstd_1.mcap"))
    found, problems = read(tmp_path / "bag")
    assert len(found) == COUNT
    assert problems == [f"{tmp_path / 'bag' / 'zstd_1.mcap'} is missing"]


@pytest.fixture(scope="module")
def sqlite_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    bag = tmp_path_factory.mktemp("sqlite") / "bag"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/t", "std_msgs/msg/String", typestore=get_typestore(Stores.ROS2_JAZZY))
        for stamp in range(1, COUNT + 1):
            writer.write(connection, stamp, MESSAGE + stamp.to_bytes(4, "little"))
    return bag


@settings(max_examples=40, deadline=None)
@given(part=st.floats(0.0, 0.99))
def test_of_a_truncated_database_only_what_was_written_is_read_or_the_file_is_refused(
    sqlite_bag: Path, tmp_path_factory: pytest.TempPathFactory, part: float
) -> None:
    whole = (sqlite_bag / "bag.db3").read_bytes()
    file = tmp_path_factory.getbasetemp() / "cut.db3"
    file.write_bytes(whole[: int(part * len(whole))])
    try:
        found, problems = read(file)
    except BagError as error:
        assert str(file) in str(error)
        return
    stamps = [stamp for _, stamp, _ in found]
    assert stamps == sorted(set(stamps))
    assert all(data == MESSAGE + stamp.to_bytes(4, "little") for _, stamp, data in found)
    assert len(found) == COUNT or problems


def test_most_of_a_truncated_database_is_read(sqlite_bag: Path, tmp_path: Path) -> None:
    whole = (sqlite_bag / "bag.db3").read_bytes()
    file = tmp_path / "cut.db3"
    file.write_bytes(whole[: int(0.9 * len(whole))])
    found, problems = read(file)
    assert len(found) > COUNT // 2
    assert problems


def test_metadata_of_a_database_is_rebuilt(sqlite_bag: Path, tmp_path: Path) -> None:
    shutil.copytree(sqlite_bag, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert main(["reindex", str(tmp_path / "bag")]) == 0
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == COUNT
        assert sum(1 for _ in reader.messages()) == COUNT


def test_a_damaged_page_of_a_database_is_said(sqlite_bag: Path, tmp_path: Path) -> None:
    file = tmp_path / "hurt.db3"
    whole = bytearray((sqlite_bag / "bag.db3").read_bytes())
    with sqlite3.connect(sqlite_bag / "bag.db3") as database:
        (page_size,) = database.execute("PRAGMA page_size").fetchone()
    middle = whole.index((COUNT // 2).to_bytes(4, "little"), len(whole) // 3) // page_size * page_size
    whole[middle : middle + page_size] = b"\xff" * page_size
    file.write_bytes(whole)
    found, problems = read(file)
    assert problems
    assert {data for _, _, data in found} <= {MESSAGE + n.to_bytes(4, "little") for n in range(1, COUNT + 1)}


def test_the_write_ahead_log_of_a_killed_recorder_is_read(sqlite_bag: Path, tmp_path: Path) -> None:
    file = tmp_path / "killed.db3"
    shutil.copyfile(sqlite_bag / "bag.db3", file)
    (tmp_path / "left").mkdir()
    with sqlite3.connect(file) as database:
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("INSERT INTO messages VALUES (?, 1, ?, ?)", (COUNT + 1, COUNT + 1, MESSAGE))
        database.commit()
        for part in ("killed.db3", "killed.db3-wal"):  # as it is while the recorder runs
            shutil.copyfile(tmp_path / part, tmp_path / "left" / part)
    found, problems = read(tmp_path / "left" / "killed.db3")
    assert len(found) == COUNT + 1
    assert any("killed.db3-wal is read" in problem for problem in problems)
