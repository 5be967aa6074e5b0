from itertools import pairwise
from pathlib import Path

from friction_msgs.msg import BrakeDemand
from std_msgs.msg import Header

from benchmarks.bags import _write
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode, encode, installed_topic
from friction_runtime.messages import from_nanoseconds, to_nanoseconds


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
