"""The recorder and the player as processes, over DDS."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest
import rclpy
from friction_msgs.msg import WheelSlip
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String

from friction_bags.bag_io.bag_format import BagError, Topic
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import encode, installed_topic
from friction_bags.bag_io.reindex import reindex
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_test_support.dds_client import PATIENCE, own_domain

SECOND = 10**9
DATA = Path(os.environ.get("FRICTION_DATA", Path(__file__).parents[2] / "shared" / "data"))
FOREIGN = DATA / "foreign_bags"


@pytest.fixture
def node() -> Iterator[Node]:
    context = Context()
    rclpy.init(context=context, domain_id=own_domain())
    node = Node("test_bags", context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    rclpy.shutdown(context=context)


class Command:
    """A friction_bags process of its own."""

    def __init__(self, directory: Path, *arguments: str) -> None:
        self.log = directory / f"{arguments[0]}.log"
        environment = {**os.environ, "ROS_DOMAIN_ID": str(own_domain())}
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "friction_bags", *arguments], stdout=log, stderr=log, env=environment
            )

    def wait_until_said(self, text: str) -> None:
        wait_for(lambda: text in self.log.read_text() or self.process.poll() is not None)
        assert text in self.log.read_text()

    def stop(self, number: int) -> int:
        self.process.send_signal(number)
        return self.process.wait(PATIENCE)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Command]]:
    commands: list[Command] = []

    def begin(*arguments: str) -> Command:
        commands.append(Command(tmp_path, *arguments))
        return commands[-1]

    yield begin
    for command in commands:
        if command.process.poll() is None:
            command.process.kill()
            command.process.wait()


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def publish_at_200_hz(publishers: list, count: int, first: int = 0) -> None:
    """Publish `count` samples on each publisher, stamped by their number in milliseconds."""
    begun = time.monotonic()
    for index in range(first, first + count):
        for publisher in publishers:
            publisher.publish(JointState(name=["a"], velocity=[float(index)], header=header(index)))
        time.sleep(max(begun + (index - first) / 200.0 - time.monotonic(), 0.0))


def header(index: int) -> Header:
    return Header(stamp=from_nanoseconds((index + 1) * 1_000_000))


def numbers(messages: list[bytes]) -> list[int]:
    """Numbers of the samples of publish_at_200_hz()."""
    return [int(deserialize_message(data, JointState).velocity[0]) for data in messages]


def recorded(bag: Path) -> dict[str, list[bytes]]:
    with BagReader(bag) as reader:
        found: dict[str, list[bytes]] = {topic.name: [] for topic in reader.counts}
        stamps = []
        for topic, stamp, data in reader.messages():
            found[topic.name].append(data)
            stamps.append(stamp)
        assert stamps == sorted(stamps)
        assert reader.problems == []
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_every_sample_of_topics_that_appear_is_recorded_and_a_signal_closes_the_bag(
    node: Node, start: Callable[..., Command], tmp_path: Path, number: int
) -> None:
    bag = tmp_path / "bag"
    car = ("--vehicle", "chapter_car", "--note", "of a test")
    recorder = start("record", "--out", str(bag), "--exclude", "unwanted", "parameter_events", *car)
    best_effort = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    early = [node.create_publisher(JointState, f"early_{index}", 100) for index in range(5)]
    wait_for(lambda: all(publisher.get_subscription_count() == 1 for publisher in early))
    publish_at_200_hz(early, 100)
    late = [node.create_publisher(JointState, "late", best_effort)]
    unwanted = node.create_publisher(String, "unwanted", 10)
    wait_for(lambda: late[0].get_subscription_count() == 1)
    assert unwanted.get_subscription_count() == 0
    publish_at_200_hz(early + late, 300, first=100)
    for publisher in early:
        publisher.wait_for_all_acked()
    assert recorder.stop(number) == 0, recorder.log.read_text()
    assert "0 lost; closed" in recorder.log.read_text()
    found = {name: numbers(data) for name, data in recorded(bag).items()}
    taken = found.pop("/late")
    assert found == {f"/early_{index}": list(range(400)) for index in range(5)}
    assert taken == list(range(400))[-len(taken) :]  # samples before the recorder has discovered its publisher are lost
    with BagReader(bag) as reader:
        (topic,) = [topic for topic in reader.counts if topic.name == "/late"]
        assert topic.qos[0].reliability.name == "BEST_EFFORT"
        assert "float64[] velocity" in topic.definition
        assert reader.custom_data == {"note": "of a test", "vehicle": "chapter_car"}


def test_a_recorder_follows_a_topic_whose_publishers_become_best_effort(
    node: Node, start: Callable[..., Command], tmp_path: Path
) -> None:
    recorder = start("record", "--out", str(tmp_path / "bag"), "--topics", "mixed")
    reliable = node.create_publisher(JointState, "mixed", 100)
    wait_for(lambda: reliable.get_subscription_count() == 1)
    other = node.create_publisher(JointState, "mixed", QoSProfile(depth=9, reliability=ReliabilityPolicy.BEST_EFFORT))
    wait_for(lambda: other.get_subscription_count() == 1)
    publish_at_200_hz([other], 100)
    wait_for(lambda: reliable.get_subscription_count() == 1)
    recorder.stop(signal.SIGINT)
    taken = numbers(recorded(tmp_path / "bag")["/mixed"])
    assert taken and taken == list(range(100))[-len(taken) :]


def test_a_killed_recorder_leaves_what_it_had_written_and_reindex_makes_it_whole(
    node: Node, start: Callable[..., Command], tmp_path: Path
) -> None:
    bag = tmp_path / "bag"
    recorder = start("record", "--out", str(bag), "--topics", "wheel_states")
    publisher = node.create_publisher(JointState, "wheel_states", 100)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    publish_at_200_hz([publisher], 300)
    wait_for(lambda: readable(bag) >= 300)  # messages are written soon after they arrive, not only at the end
    recorder.process.kill()
    recorder.process.wait()
    assert not (bag / "metadata.yaml").exists()
    with BagReader(bag) as reader:
        messages = list(reader.messages())
        assert any("reindex" in problem for problem in reader.problems)
    assert numbers([data for _, _, data in messages]) == list(range(300))
    reindex(bag)
    assert recorded(bag) == {"/wheel_states": [data for _, _, data in messages]}


def readable(bag: Path) -> int:
    """Number of the messages that a bag has on disk."""
    try:
        with BagReader(bag) as reader:
            return sum(1 for _ in reader.messages())
    except BagError:  # nothing that can be read has been written yet
        return 0


def test_recording_into_an_existing_directory_is_refused(start: Callable[..., Command], tmp_path: Path) -> None:
    recorder = start("record", "--out", str(tmp_path))
    assert recorder.process.wait(PATIENCE) == 2
    assert "exists" in recorder.log.read_text()


def same(received: list[bytes], sent: list[bytes]) -> bool:
    """Whether the same bytes came; on the wire a message is padded to a multiple of 4 bytes."""
    return len(received) == len(sent) and all(
        after[: len(before)] == before and len(after) - len(before) < 4
        for before, after in zip(sent, received, strict=True)
    )


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Two seconds of two topics, recorded at other times than stamped."""
    path = tmp_path / "original"
    with BagWriter(path) as writer:
        slip = writer.add_topic(installed_topic("/front_left/slip", WheelSlip))
        wheels = writer.add_topic(installed_topic("/wheel_states", JointState))
        for index in range(400):
            states = JointState(name=["front_left"], velocity=[float(index)], header=header(index))
            message = WheelSlip(wheel="front_left", slip=index / 1000.0, header=header(index))
            writer.write(wheels, SECOND + index * 5_000_000, encode(states))
            writer.write(slip, SECOND + index * 5_000_000 + 1_000_000, encode(message))
    return path


class Listener:
    """Takes what arrives on a topic, raw."""

    def __init__(self, node: Node, kind: type, topic: str) -> None:
        self.subscription = node.create_subscription(kind, topic, lambda _: None, 5000, raw=True)
        self.kind = kind
        self.data: list[bytes] = []
        self.times: list[int] = []

    def take(self) -> int:
        with self.subscription.handle:
            while (taken := self.subscription.handle.take_message(self.kind, True)) is not None:
                self.data.append(taken[0])
                self.times.append(taken[1]["received_timestamp"])
        return len(self.data)


def test_a_replay_arrives_complete_in_order_and_with_original_stamps(
    node: Node, start: Callable[..., Command], bag: Path
) -> None:
    wheels = Listener(node, JointState, "wheel_states")
    slip = Listener(node, WheelSlip, "front_left/slip")
    player = start("play", str(bag), "--rate", "2", "--wait", "20")
    assert player.process.wait(PATIENCE) == 0, player.log.read_text()
    original = recorded(bag)
    wait_for(lambda: wheels.take() >= 400 and slip.take() >= 400)
    assert same(wheels.data, original["/wheel_states"])
    assert same(slip.data, original["/front_left/slip"])
    # two seconds at double speed: never sooner but for a late start; a busy machine may take longer
    assert (wheels.times[-1] - wheels.times[0]) / SECOND > 0.6


def test_a_prompt_topic_is_waited_for_also_while_another_answers_three_samples_late(
    node: Node, start: Callable[..., Command], bag: Path
) -> None:
    prompt, late = (node.create_publisher(JointState, name, 100) for name in ("prompt", "late"))
    wheels = Listener(node, JointState, "wheel_states")
    follow = ("--as-fast-as-possible", "--follow", "prompt", "late")
    player = start("play", str(bag), "--topics", "wheel_states", "--duration", "0.1", *follow, "--wait", "20")
    answered, unanswered = 0, []
    while player.process.poll() is None:
        if wheels.take() == answered:
            time.sleep(0.0005)
            continue
        if answered >= 3:
            late.publish(JointState(header=header(answered - 3)))
        time.sleep(0.02)  # an eager player would publish more meanwhile
        unanswered.append(wheels.take() - answered)
        prompt.publish(JointState(header=header(answered)))
        answered += 1
    assert player.process.returncode == 0, player.log.read_text()
    assert answered == 20
    assert max(unanswered) == 1


def test_a_part_of_a_bag_is_replayed_under_another_name_and_namespace_in_a_loop(
    node: Node, start: Callable[..., Command], bag: Path
) -> None:
    wheels = Listener(node, JointState, "/car/other")
    slip = Listener(node, WheelSlip, "/car/front_left/slip")
    arguments = ("--start-offset", "0.5", "--duration", "0.25", "--rate", "10")
    renamed = ("--namespace", "car", "--ros-args", "-r", "/car/wheel_states:=/car/other")
    player = start("play", str(bag), "--topics", "wheel_states", "--loop", *arguments, "--wait", "20", *renamed)
    wait_for(lambda: wheels.take() >= 150)
    assert player.stop(signal.SIGTERM) == 0
    part = recorded(bag)["/wheel_states"][100:150]
    assert same(wheels.data[:150], part * 3)
    assert slip.take() == 0


def test_the_clock_of_a_replay_is_the_recording_time(node: Node, start: Callable[..., Command], bag: Path) -> None:
    clock = Listener(node, Clock, "/clock")
    player = start("play", str(bag), "--clock", "50", "--topics", "wheel_states", "--wait", "2.5")
    assert player.process.wait(PATIENCE) == 0
    clock.take()
    times = [to_nanoseconds(deserialize_message(data, Clock).clock) for data in clock.data]
    assert len(times) > 10
    assert {after - before for before, after in pairwise(times)} == {SECOND // 50}
    assert SECOND <= times[0] < times[-1] <= SECOND + 399 * 5_000_000


@pytest.mark.skipif(not FOREIGN.is_dir(), reason=f"{FOREIGN} is absent (set FRICTION_DATA)")
@pytest.mark.parametrize("name", ["talker_mcap", "talker_sqlite3"])
def test_a_bag_of_rosbag2_is_replayed(node: Node, start: Callable[..., Command], name: str) -> None:
    listener = Listener(node, String, "topic")
    player = start("play", str(FOREIGN / name), "--rate", "5", "--topics", "topic", "--wait", "20")
    assert player.process.wait(PATIENCE) == 0, player.log.read_text()
    wait_for(lambda: listener.take() >= 10)
    assert same(listener.data, recorded(FOREIGN / name)["/topic"])


def test_a_truncated_bag_is_replayed_as_far_as_it_goes_and_said_to_be_damaged(
    node: Node, start: Callable[..., Command], bag: Path
) -> None:
    file = bag / "original_0.mcap"
    original = recorded(bag)["/wheel_states"]
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    listener = Listener(node, JointState, "wheel_states")
    player = start("play", str(bag), "--rate", "10", "--topics", "wheel_states", "--wait", "20")
    assert player.process.wait(PATIENCE) == 1
    assert "damaged" in player.log.read_text()
    assert str(file) in player.log.read_text()
    with BagReader(bag) as reader:
        count = sum(topic.name == "/wheel_states" for topic, _, _ in reader.messages())
    wait_for(lambda: listener.take() >= count)
    assert same(listener.data, original[:count])


def test_a_topic_whose_type_is_not_installed_is_named_and_the_others_are_replayed(
    node: Node, start: Callable[..., Command], tmp_path: Path
) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        writer.write(writer.add_topic(Topic("/foreign", "nowhere_msgs/msg/Thing")), SECOND, bytes(8))
        writer.write(writer.add_topic(installed_topic("/words", String)), SECOND, encode(String(data="known")))
    listener = Listener(node, String, "words")
    player = start("play", str(tmp_path / "bag"), "--wait", "20")
    assert player.process.wait(PATIENCE) == 0, player.log.read_text()
    assert "skipping /foreign" in player.log.read_text()
    wait_for(lambda: listener.take() == 1)


@pytest.mark.parametrize("arguments", [("nowhere",), ("{bag}", "--start-offset", "9"), ("{bag}", "--topics", "no")])
def test_nothing_to_replay_is_an_error_with_a_reason(
    start: Callable[..., Command], bag: Path, arguments: tuple[str, ...]
) -> None:
    player = start("play", *(argument.format(bag=bag) for argument in arguments))
    assert player.process.wait(PATIENCE) == 2
    assert player.log.read_text().startswith("error: ")


def test_a_first_message_at_zero_is_replayed_and_a_long_gap_is_passed_over(
    node: Node, start: Callable[..., Command], tmp_path: Path
) -> None:
    with BagWriter(tmp_path / "old") as writer:
        channel = writer.add_topic(installed_topic("/text", String))
        for stamp in (0, 1_700_000_000 * SECOND, 1_700_000_000 * SECOND + 1):
            writer.write(channel, stamp, encode(String(data=str(stamp))))
    play = start("play", str(tmp_path / "old"), "--wait", "0")
    assert play.process.wait(PATIENCE) == 0
    said = play.log.read_text()
    assert "3 messages on 1 topics replayed" in said
    assert "nothing for 1700000000 s before /text: passed over" in said
