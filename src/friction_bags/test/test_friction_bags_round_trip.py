import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
import yaml
from friction_msgs.msg import Validity, WheelSlip
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Header, Message
from mcap.stream_reader import StreamReader
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import message_definition
from friction_runtime.installed import UnknownTypeError, message_class

FOREVER = QosTime(9223372036, 854775807)
QOS = Qos(
    QosHistory.KEEP_LAST,
    7,
    QosReliability.BEST_EFFORT,
    QosDurability.TRANSIENT_LOCAL,
    FOREVER,
    FOREVER,
    QosLiveliness.AUTOMATIC,
    FOREVER,
    False,
)


def installed_topic(name: str, kind: str) -> Topic:
    definition = message_definition(kind)
    return Topic(name, kind, definition.text, "ros2msg", definition.type_hash, (QOS,))


TOPICS = [installed_topic("/wheel_states", "sensor_msgs/msg/JointState"), installed_topic("/s", "std_msgs/msg/String")]
STAMPS = st.integers(min_value=1, max_value=2**62)
MESSAGES = st.lists(st.tuples(st.sampled_from(TOPICS), STAMPS, st.binary(max_size=64)), max_size=60)


@settings(max_examples=40, deadline=None)
@given(messages=MESSAGES, chunk_size=st.sampled_from([50, 400, 1 << 20]), flush_every=st.integers(1, 20))
def test_what_is_written_is_read_in_the_order_of_its_stamps(
    tmp_path_factory: pytest.TempPathFactory, messages: list, chunk_size: int, flush_every: int
) -> None:
    bag = tmp_path_factory.mktemp("bags") / "bag"
    messages = [(topic, stamp, b"\0\1\0\0" + data) for topic, stamp, data in messages]
    with BagWriter(bag, chunk_size=chunk_size) as writer:
        channels = {topic: writer.add_topic(topic) for topic in TOPICS}
        for index, (topic, stamp, data) in enumerate(messages):
            writer.write(channels[topic], stamp, data)
            if index % flush_every == 0:
                writer.flush()
    with BagReader(bag) as reader:
        found = [(topic.name, stamp, data) for topic, stamp, data in reader.messages()]
        assert reader.problems == []
        assert reader.message_count == len(messages)
        if messages:
            assert reader.start == min(stamp for _, stamp, _ in messages)
            assert reader.end == max(stamp for _, stamp, _ in messages)
    assert sorted(found) == sorted((topic.name, stamp, data) for topic, stamp, data in messages)
    assert all(before[1] <= after[1] for before, after in pairwise(found))


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_another_reader_decodes_the_messages_without_knowing_their_types(tmp_path: Path, compression: str) -> None:
    message = WheelSlip(wheel="front_left", slip=0.125, validity=Validity(valid=True))
    message.header.stamp.sec = 3
    topic = installed_topic("/front_left/slip", "friction_msgs/msg/WheelSlip")
    with BagWriter(tmp_path / "bag", compression=compression) as writer:  # type: ignore[arg-type]
        channel = writer.add_topic(topic)
        for index in range(100):
            writer.write(channel, 1000 + index, serialize_message(message))
    with AnyReader([tmp_path / "bag"]) as reader:
        decoded = [reader.deserialize(data, connection.msgtype) for connection, _, data in reader.messages()]
        (connection,) = reader.connections
    assert len(decoded) == 100
    found = {(each.wheel, each.slip, each.validity.valid, each.header.stamp.sec) for each in decoded}  # type: ignore[attr-defined]
    assert found == {("front_left", 0.125, True, 3)}
    assert connection.digest == topic.type_hash
    assert connection.ext.offered_qos_profiles == [QOS]  # type: ignore[union-attr]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_the_strict_reader_of_the_mcap_package_accepts_index_and_checksums(tmp_path: Path, compression: str) -> None:
    with BagWriter(tmp_path / "bag", compression=compression, chunk_size=500) as writer:  # type: ignore[arg-type]
        for stamp in range(1, 200):
            writer.write(writer.add_topic(TOPICS[stamp % 2]), stamp, bytes(stamp), sent=stamp + 7, sequence=stamp + 9)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
        indexed = [
            (message.log_time, message.publish_time, message.sequence, message.data)
            for _, _, message in make_reader(stream, validate_crcs=True).iter_messages()
        ]
        stream.seek(0)
        records = list(StreamReader(stream, validate_crcs=True).records)
    assert indexed == [(stamp, stamp + 7, stamp + 9, bytes(stamp)) for stamp in range(1, 200)]
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 199
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count > 10
    assert sum(isinstance(record, Message) for record in records) == 199
    header = records[0]
    assert isinstance(header, Header)
    assert header.profile == "ros2"


def test_custom_definitions_are_embedded_with_all_they_refer_to() -> None:
    text = message_definition("friction_msgs/msg/WheelSlip").text
    assert "float64 slip" in text.split("=" * 80)[0]
    assert {"MSG: std_msgs/Header", "MSG: builtin_interfaces/Time"} <= set(text.splitlines())


@pytest.mark.parametrize("kind", ["nowhere_msgs/msg/Thing", "std_msgs/msg/Nothing"])
def test_a_type_that_is_not_installed_is_named(kind: str) -> None:
    with pytest.raises(UnknownTypeError, match=kind.split("/")[0]):
        message_class(kind)
    with pytest.raises(UnknownTypeError, match=kind.split("/")[0]):
        message_definition(kind)


def test_metadata_says_what_rosbag2_wants_to_know(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag", custom_data={"note": "a road"}) as writer:
        writer.write(writer.add_topic(TOPICS[0]), 5, b"\0\1\0\0")
        writer.write(writer.add_topic(TOPICS[0]), 12, b"\0\1\0\0")
        writer.add_topic(TOPICS[1])
    information = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["starting_time"] == {"nanoseconds_since_epoch": 5}
    assert information["duration"] == {"nanoseconds": 7}
    assert information["message_count"] == 2
    assert information["custom_data"] == {"note": "a road"}
    assert [(tmp_path / "bag" / name).is_file() for name in information["relative_file_paths"]] == [True]
    first, second = information["topics_with_message_count"]
    assert (first["message_count"], second["message_count"]) == (2, 0)
    assert first["topic_metadata"]["offered_qos_profiles"][0]["reliability"] == "best_effort"


def test_the_same_messages_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        with BagWriter(tmp_path / name / "bag") as writer:
            for stamp in range(1, 500):
                writer.write(writer.add_topic(TOPICS[0]), stamp, bytes([stamp % 256]) * 40)
    for file in ("bag_0.mcap", "metadata.yaml"):
        assert (tmp_path / "a/bag" / file).read_bytes() == (tmp_path / "b/bag" / file).read_bytes()


def test_an_existing_directory_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("data")
    with pytest.raises(BagError, match="exists"):
        BagWriter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["precious"]


FULL_DISK = """
import resource, sys
from pathlib import Path
from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_writer import BagWriter
writer = BagWriter(Path(sys.argv[1]), compression="none")
channel = writer.add_topic(Topic("/a", "std_msgs/msg/String", "string data", "ros2msg"))
resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))
try:
    for stamp in range(1, 10_000):
        writer.write(channel, stamp, bytes(100))
        if stamp % 50 == 0:
            writer.flush()
except BagError as error:
    writer.close()
    print(error)
"""


def test_a_full_disk_is_said_with_the_way_out_and_what_was_flushed_is_kept(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    done = subprocess.run([sys.executable, "-c", FULL_DISK, str(bag)], capture_output=True, text=True, check=True)
    assert str(bag) in done.stdout
    assert "reindex" in done.stdout
    assert done.stderr == ""
    with BagReader(bag) as reader:
        stamps = [stamp for _, stamp, _ in reader.messages()]
    assert stamps == list(range(1, len(stamps) + 1))
    assert len(stamps) >= 150
