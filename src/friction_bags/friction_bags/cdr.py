"""Messages to CDR and back by rosbags.

rclpy's own serialization leaves the padding between fields as it finds it in memory, and appends padding to a message
that ends with an empty sequence of doubles; rosbags pads with zeros and adds nothing, so that the same message always
gives the same bytes. Its decoding takes half the time of rclpy's, which is kept for the messages with that padding:
rosbags refuses them.
"""

from array import array
from functools import cache
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from friction_bags.bag_format import Topic
from friction_bags.message_definition import message_definition


@cache
def type_name(kind: Any) -> str:
    """Name of a message class, e.g. sensor_msgs/msg/JointState."""
    return f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"


def installed_topic(name: str, kind: type) -> Topic:
    """Topic of a message class, with its definition.

    Raises:
        UnknownTypeError: the definition is not installed.
    """
    definition = message_definition(type_name(kind))
    return Topic(name, type_name(kind), definition.text, "ros2msg", definition.type_hash)


def encode(message: Any) -> bytes:
    """CDR of a message, little endian, with its encapsulation header.

    Raises:
        UnknownTypeError: the definition of the message is not installed.
    """
    kind: Any = type(message)
    data = _typestore(kind).serialize_cdr(_Numpy(message) if _has_sequence(kind) else message, type_name(kind))
    return bytes(data)


def decode(data: bytes, kind: Any) -> Any:
    """Fields of a message of a class from CDR: to be read like the message, not to be published.

    Raises:
        ValueError: the data is no message of this class.
    """
    try:
        return _typestore(kind).deserialize_cdr(data, type_name(kind))
    except SerdeError:
        return _decode_padded(data, kind)


def _decode_padded(data: bytes, kind: Any) -> Any:
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # rclpy has no common class for what its middleware refuses
        raise ValueError(f"not a {type_name(kind)}: {error}") from error


class _Numpy:
    """A message whose number sequences are numpy arrays, as rosbags has them."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._message, name)
        return np.array(value, dtype=value.typecode) if isinstance(value, array) else value


@cache
def _has_sequence(kind: Any) -> bool:
    return any("sequence<" in field for field in kind.get_fields_and_field_types().values())


@cache
def _typestore(kind: Any) -> Typestore:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(type_name(kind)).text, type_name(kind)))
    return store
