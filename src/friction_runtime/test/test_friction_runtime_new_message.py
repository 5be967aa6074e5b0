"""Messages made without defaults are the messages the generated constructor makes."""

import pytest
from rclpy.serialization import deserialize_message, serialize_message
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


def test_a_forgotten_field_cannot_be_published() -> None:
    message = new_message(Header)
    message.stamp = from_nanoseconds(1)
    with pytest.raises(AttributeError):
        serialize_message(message)
