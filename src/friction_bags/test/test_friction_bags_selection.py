import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from friction_bags.record_replay.topics import TopicSelection, matching, replayed, stored


@pytest.mark.parametrize(
    ("include", "exclude", "namespace", "name", "wanted"),
    [
        ([], [], "/", "/anything", True),
        (["wheel_states"], [], "/", "/wheel_states", True),
        (["wheel_states"], [], "/", "/wheel_states2", False),
        (["wheel_states"], [], "/car", "/car/wheel_states", True),
        (["wheel_states"], [], "/car", "/wheel_states", False),
        (["/wheel_states"], [], "/car", "/wheel_states", True),
        (["*/slip"], [], "/", "/front_left/slip", True),
        (["*"], ["truth/*"], "/", "/truth/front_left/slip", False),
        ([], ["rosout"], "/", "/rosout", False),
    ],
)
def test_topics_are_selected_by_name_pattern_and_namespace(
    include: list[str], exclude: list[str], namespace: str, name: str, wanted: bool
) -> None:
    assert TopicSelection(include, exclude, namespace).wants(name) is wanted


def publisher(reliability: ReliabilityPolicy, durability: DurabilityPolicy) -> TopicEndpointInfo:
    return TopicEndpointInfo(qos_profile=QoSProfile(depth=3, reliability=reliability, durability=durability))


@pytest.mark.parametrize("reliabilities", [["RELIABLE"], ["RELIABLE", "BEST_EFFORT"], ["BEST_EFFORT"]])
@pytest.mark.parametrize("durabilities", [["TRANSIENT_LOCAL"], ["VOLATILE", "TRANSIENT_LOCAL"], ["VOLATILE"]])
def test_the_recorder_asks_for_no_more_than_every_publisher_offers(
    reliabilities: list[str], durabilities: list[str]
) -> None:
    publishers = [publisher(ReliabilityPolicy[r], DurabilityPolicy[d]) for r in reliabilities for d in durabilities]
    profile = matching(publishers)
    assert (profile.reliability == ReliabilityPolicy.RELIABLE) == (reliabilities == ["RELIABLE"])
    assert (profile.durability == DurabilityPolicy.TRANSIENT_LOCAL) == (durabilities == ["TRANSIENT_LOCAL"])


def test_the_player_is_reliable_and_keeps_what_was_latched() -> None:
    sensor = stored(QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT))
    assert replayed([sensor]).reliability == ReliabilityPolicy.RELIABLE
    assert replayed([sensor]).durability == DurabilityPolicy.VOLATILE
    latched = stored(QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    assert (replayed([latched]).durability, replayed([latched]).depth) == (DurabilityPolicy.TRANSIENT_LOCAL, 5)
    assert replayed([]).reliability == ReliabilityPolicy.RELIABLE
