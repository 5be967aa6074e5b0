from itertools import pairwise
from pathlib import Path

from friction_msgs.msg import BrakeDemand
from mcap.reader import make_reader
from std_msgs.msg import Header, String

from benchmarks.bags import _write, library_seconds
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic
from friction_runtime.stamps import from_nanoseconds, to_nanoseconds


def test_a_long_bag_repeats_the_minute_with_stamps_that_go_on(tmp_path: Path) -> None:
    topic = installed_topic("/brake_demand", BrakeDemand)
    minute = []
    for index in range(60):
        stamp = 10**12 + index * 10**9 + 5_000_000
        message = BrakeDemand(header=Header(stamp=from_nanoseconds(stamp)), pressure=float(index))
        minute.append((topic, stamp, encode(message)))
    _write(tmp_path / "bag", minute, 3)
    with BagReader(tmp_path / "bag") as reader:
        rows = [(stamp, decode(data, BrakeDemand)) for _, stamp, data in reader.messages()]
    assert [to_nanoseconds(message.header.stamp) for _, message in rows] == [stamp for stamp, _ in rows]
    assert {after - before for (before, _), (after, _) in pairwise(rows)} == {10**9}
    assert [message.pressure for _, message in rows] == [float(index) for index in range(60)] * 3


def test_the_libraries_are_timed_on_the_same_messages(tmp_path: Path) -> None:
    taken, made = installed_topic("/brake_demand", BrakeDemand), installed_topic("/text", String)
    rows = [(taken, 10**12, encode(BrakeDemand(pressure=2.0))), (made, 10**12 + 1, encode(String(data="made")))]
    with BagWriter(tmp_path / "bag") as writer:
        for topic, stamp, data in rows:
            writer.write(writer.add_topic(topic), stamp, data)
    assert library_seconds(tmp_path / "bag", {taken.name}, tmp_path / "again.mcap") > 0.0
    with (tmp_path / "again.mcap").open("rb") as file:
        found = [
            (channel.topic, message.log_time, message.data) for _, channel, message in make_reader(file).iter_messages()
        ]
    assert found == [(topic.name, stamp, data) for topic, stamp, data in rows]
