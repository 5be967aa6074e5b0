"""Files that are small and would fill the machine when unpacked."""

import struct
import subprocess
import sys
import zlib
from io import BytesIO
from pathlib import Path

import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Header, Schema
from mcap.writer import MCAP0_MAGIC

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.decompression import GIB, VARIABLE

BLOCK = 1 << 17
MOST_MEMORY = 1_500_000_000
WITHIN_MEMORY = f"""
import resource, sys
from pathlib import Path
from friction_bags.bag_io.bag_reader import BagReader
resource.setrlimit(resource.RLIMIT_DATA, ({MOST_MEMORY}, {MOST_MEMORY}))
for bag in sys.argv[1:]:
    with BagReader(Path(bag)) as reader:
        count = sum(1 for _ in reader.messages())
        print(bag, count, "messages,", *reader.problems, sep=" ", flush=True)
"""


def zeros(size: int, *, told: bool = True) -> bytes:
    """A frame of zstd that holds `size` zeros, in blocks of four bytes that stand for 128 KiB each."""
    head = b"\x28\xb5\x2f\xfd" + (b"\xc0\x38" + struct.pack("<Q", size) if told else b"\x00\x38")
    lengths = [min(BLOCK, size - begin) for begin in range(0, size, BLOCK)]
    blocks = [(length << 3 | 2 | (k == len(lengths) - 1)).to_bytes(3, "little") for k, length in enumerate(lengths)]
    return head + b"\0".join(blocks) + b"\0"


def mcap(data: bytes, claim: int, *, chunks: int = 1, index: bool = True) -> bytes:
    """A file of chunks with the same data, that claim to hold `claim` bytes, all at the same time."""
    schema = Schema(id=1, name="std_msgs/msg/String", encoding="ros2msg", data=b"string data\n")
    channel = Channel(id=1, schema_id=1, topic="/t", message_encoding="cdr", metadata={})
    file = BytesIO()
    file.write(MCAP0_MAGIC)

    def write(*records: Header | Schema | Channel | Chunk | ChunkIndex) -> tuple[int, int]:
        builder, begin = RecordBuilder(), file.tell()
        for record in records:
            record.write(builder)
        return begin, file.write(builder.end())

    write(Header(profile="ros2", library=""), schema, channel)
    places = [
        write(
            Chunk(
                compression="zstd",
                data=data,
                message_start_time=1,
                message_end_time=9,
                uncompressed_crc=0,
                uncompressed_size=claim,
            )
        )
        for _ in range(chunks)
    ]
    begin = file.tell()
    if index:
        write(schema, channel)
        for at, length in places:
            write(
                ChunkIndex(
                    chunk_length=length,
                    chunk_start_offset=at,
                    compression="zstd",
                    compressed_size=len(data),
                    message_end_time=9,
                    message_index_length=31,
                    message_index_offsets={1: at + length},
                    message_start_time=1,
                    uncompressed_size=claim,
                )
            )
    builder = RecordBuilder()
    Footer(summary_start=begin if index else 0, summary_offset_start=0, summary_crc=0).write(builder)
    return file.getvalue() + builder.end() + MCAP0_MAGIC


def test_a_frame_of_zeros_is_one() -> None:
    assert zstandard.decompress(zeros(300_000)) == bytes(300_000)


def test_no_file_takes_more_than_one_gibibyte_and_a_half(tmp_path: Path) -> None:
    bombs = {
        "no_index": mcap(zeros(4 * GIB), 4 * GIB, index=False),
        "index": mcap(zeros(4 * GIB), 4 * GIB),
        "claims_little": mcap(zeros(4 * GIB), 1000, index=False),
        "claims_little_by_its_index": mcap(zeros(4 * GIB), 1000),
        "untold": mcap(zeros(4 * GIB, told=False), 1 << 20, index=False),
        "many": mcap(zeros(GIB // 2), GIB // 2, chunks=3),
        "claims_what_is_not_there": mcap(b"", 2**63, index=False),
    }
    files = []
    for name, data in bombs.items():
        files.append(tmp_path / f"{name}.mcap")
        files[-1].write_bytes(data)
    command = [sys.executable, "-c", WITHIN_MEMORY, *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-2000:]
    said = dict(zip(bombs, done.stdout.splitlines(), strict=True))
    for name, text in said.items():
        assert f"{name}.mcap 0 messages, {tmp_path / name}.mcap:" in text
    for name in ("no_index", "index", "many", "claims_what_is_not_there"):
        assert "GiB unpacked, more than 1 GiB" in said[name]


def test_a_file_is_unpacked_up_to_the_limit_and_the_text_names_what_raises_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "bag.mcap.zstd"
    file.write_bytes(zstandard.compress(mcap(zeros(1000), 1000)) + b"")
    packed = zeros(64 << 20)
    (tmp_path / "zeros.mcap.zstd").write_bytes(packed)
    monkeypatch.setenv(VARIABLE, "0.01")
    with BagReader(file) as reader:
        assert not reader.problems
    with pytest.raises(BagError, match=rf"more than 0\.01 GiB: set {VARIABLE}"):
        BagReader(tmp_path / "zeros.mcap.zstd")


@pytest.mark.parametrize("text", ["", "much", "0", "-1", "nan", "inf"])
def test_a_limit_that_is_no_number_is_named(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bag.mcap").write_bytes(mcap(zeros(1000), 1000))
    monkeypatch.setenv(VARIABLE, text)
    assert main(["info", str(tmp_path / "bag.mcap")]) == 2
    assert VARIABLE in capsys.readouterr().err


def test_a_message_that_claims_more_than_the_limit_is_not_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with BagWriter(tmp_path / "bag", compression="none") as writer:
        topic = writer.add_topic(Topic("/t", "std_msgs/msg/String", "string data\n", "ros2msg"))
        writer.write(topic, 1, zstandard.compress(bytes(100)))
        writer.write(topic, 2, zeros(1 << 26))
    monkeypatch.setenv(VARIABLE, "0.01")
    with BagReader(tmp_path / "bag") as reader:
        assert [data for _, _, data in reader.messages()] == [bytes(100)]
        assert any("a message takes 0.06 GiB" in problem for problem in reader.problems)


def test_a_changed_byte_of_the_summary_is_said_and_all_messages_are_read(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        topic = writer.add_topic(Topic("/t", "std_msgs/msg/String", "string data\n", "ros2msg"))
        for stamp in range(1, 11):
            writer.write(topic, stamp, b"\0\1\0\0" + stamp.to_bytes(4, "little"))
    file = tmp_path / "bag/bag_0.mcap"
    whole = file.read_bytes()
    (begin,) = struct.unpack_from("<Q", whole, len(whole) - 8 - 20)
    end = len(whole) - 8 - 4
    (checksum,) = struct.unpack_from("<I", whole, end)
    assert zlib.crc32(whole[begin:end]) == checksum
    for at in range(begin, end - 25):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0x40]) + whole[at + 1 :])
        with BagReader(tmp_path / "bag") as reader:
            assert any("summary" in problem for problem in reader.problems)
            assert [stamp for _, stamp, _ in reader.messages()] == list(range(1, 11))
