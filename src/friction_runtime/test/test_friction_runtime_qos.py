"""Quality of service over DDS: what an override reaches, and what commands promise."""

from collections.abc import Iterator

import pytest
from friction_msgs.msg import BrakeCommand, WheelSlip
from rclpy.qos import LivelinessPolicy, QoSProfile, ReliabilityPolicy

from friction_runtime import qos
from friction_test_support.dds_client import DdsClient, dds_client

OVERRIDDEN = (
    *("--ros-args", "-p", "qos_overrides./slip.publisher.depth:=5"),
    *("-p", "qos_overrides./front_left/brake_command.publisher.lifespan:=250000000"),
    *("-p", "qos_overrides./front_left/brake_command.subscription.deadline:=0"),
)


@pytest.fixture
def client() -> Iterator[DdsClient]:
    with dds_client(OVERRIDDEN) as made:
        yield made


def offered(client: DdsClient, topic: str) -> QoSProfile:
    """Profile of the only publisher of a topic."""
    client.until(lambda: client.node.count_publishers(topic) == 1)
    (publisher,) = client.node.get_publishers_info_by_topic(topic)
    return publisher.qos_profile


def test_an_override_of_one_topic_does_not_reach_the_topics_after_it(client: DdsClient) -> None:
    depths = []
    for topic in ("slip", "other_slip"):
        qos.publish(client.node, WheelSlip, topic)
        depths.append(client.node.get_parameter(f"qos_overrides./{topic}.publisher.depth").value)
    assert depths == [5, 100]
    assert qos.ESTIMATE.depth == 100


def test_a_command_promises_a_deadline_and_a_sign_of_life_and_is_not_sent_when_it_is_old(client: DdsClient) -> None:
    qos.publish(client.node, BrakeCommand, "rear_left/brake_command", qos.command(0.1))
    profile = offered(client, "rear_left/brake_command")
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert profile.deadline.nanoseconds == 50_000_000
    assert profile.lifespan.nanoseconds == 100_000_000
    assert profile.liveliness == LivelinessPolicy.AUTOMATIC
    assert profile.liveliness_lease_duration.nanoseconds == 200_000_000


def test_what_a_command_promises_can_be_overridden(client: DdsClient) -> None:
    qos.publish(client.node, BrakeCommand, "front_left/brake_command", qos.command(0.1))
    assert offered(client, "front_left/brake_command").lifespan.nanoseconds == 250_000_000


@pytest.mark.parametrize("profile", [qos.COMMAND, qos.ESTIMATE, qos.SENSOR])
def test_commands_match_their_consumer_the_recorder_and_the_monitor(client: DdsClient, profile: QoSProfile) -> None:
    publisher = qos.publish(client.node, BrakeCommand, "rear_left/brake_command", qos.command(0.1))
    qos.subscribe(client.node, BrakeCommand, "rear_left/brake_command", lambda _: None, profile)
    client.until(lambda: publisher.get_subscription_count() == 1)


def test_a_consumer_matches_no_sender_without_deadline_unless_an_override_says_so(client: DdsClient) -> None:
    strict = qos.publish(client.node, BrakeCommand, "rear_left/brake_command")
    qos.subscribe(client.node, BrakeCommand, "rear_left/brake_command", lambda _: None, qos.COMMAND)
    overridden = qos.subscribe(client.node, BrakeCommand, "front_left/brake_command", lambda _: None, qos.COMMAND)
    assert client.node.get_parameter("qos_overrides./front_left/brake_command.subscription.deadline").value == 0
    promising = qos.publish(client.node, BrakeCommand, "front_left/brake_command", qos.command(0.1))
    client.until(lambda: promising.get_subscription_count() == 1)
    assert overridden.get_publisher_count() == 1
    assert strict.get_subscription_count() == 0
