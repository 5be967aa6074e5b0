"""Messages made without defaults are the messages the generated constructor makes."""

from array import array
from copy import copy, deepcopy

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from friction_runtime.new_message import new_message
from friction_runtime.stamps import from_nanoseconds


def test_a_message_with_every_field_set_equals_one_of_the_constructor_and_travels() -> None:
    message = new_message(Header)
    message.stamp = from_nanoseconds(1_500_000_007)
    message.frame_id = "front_left"
    made = Header(stamp=from_nanoseconds(1_500_000_007), frame_id="front_left")
    assert message == made
    assert made == message
    assert repr(message) == repr(made)
    assert isinstance(message, Header)
    assert deserialize_message(serialize_message(message), Header) == made


def test_a_message_with_an_array_can_be_shown_and_copied() -> None:
    message = new_message(JointState)
    message.header = Header()
    message.name = ["front_left"]
    message.position, message.velocity, message.effort = array("d"), array("d", [1.0]), array("d")
    made = JointState(name=["front_left"], velocity=[1.0])
    assert repr(message) == repr(made)
    assert deepcopy(message) == copy(message) == made


def test_a_forgotten_field_cannot_be_published() -> None:
    message = new_message(Header)
    message.stamp = from_nanoseconds(1)
    with pytest.raises(AttributeError):
        serialize_message(message)
