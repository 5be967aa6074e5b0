"""Messages to CDR and back.

rclpy's own serialization does not initialise the padding between fields, and appends padding to a message that ends
with an empty sequence of doubles; rosbags pads with zeros and appends nothing, so that equal messages give equal bytes.
Its decoding takes half the time of rclpy's, which is kept for messages with that padding: rosbags refuses them. A
message with the same lengths as an earlier one is read and written by its layout, with the same bytes and values as by
rosbags in a fraction of the time.
"""

from array import array
from typing import Any, Final

import numpy as np
from rclpy.serialization import deserialize_message
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.message_definition import message_definition, type_name
from friction_runtime.cdr_codec import LayoutCodec


def installed_topic(name: str, kind: type) -> Topic:
    """Return the topic of a message class, with its definition.

    Raises:
        UnknownTypeError: the definition is not installed.
    """
    definition = message_definition(type_name(kind))
    return Topic(name, type_name(kind), definition.text, "ros2msg", definition.type_hash)


def encode(message: Any) -> bytes:
    """Return the CDR of a message, little endian, with its encapsulation header.

    Raises:
        UnknownTypeError: the definition of the message is not installed.
    """
    return _codec_of(type(message)).encode(message)


def decode(data: bytes, kind: Any) -> Any:
    """Decode CDR to an object with the fields of a message: to be read like the message, not to be published.

    Raises:
        ValueError: the data is not a message of this class.
    """
    return _codec_of(kind).decode(data)


class _Codec:
    """Messages of one class to CDR and back: by a layout that fits, else by rosbags."""

    def __init__(self, kind: Any) -> None:
        self._kind = kind
        self._name = type_name(kind)
        self._store: Any = get_typestore(Stores.EMPTY)
        self._store.register(get_types_from_msg(message_definition(self._name).text, self._name))
        self._layouts = LayoutCodec(kind, lambda each: self._store.types[type_name(each)])

    def encode(self, message: Any) -> bytes:
        written = self._layouts.write(message)
        return bytes(self._store.serialize_cdr(_Numpy(message), self._name)) if written is None else written

    def decode(self, data: bytes) -> Any:
        message = self._layouts.read(data)
        if message is not None:
            return message
        try:
            message = self._store.deserialize_cdr(data, self._name)
        except SerdeError:
            return self._decode_padded(data)
        self._layouts.learn(data, message)
        return message

    def _decode_padded(self, data: bytes) -> Any:
        try:
            return deserialize_message(data, self._kind)
        except Exception as error:  # rclpy has no common class for errors of its middleware
            raise ValueError(f"not a {self._name}: {error}") from error


class _Numpy:
    """A message whose number sequences are numpy arrays, as rosbags writes them."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._message, name)
        return np.array(value, dtype=value.typecode) if isinstance(value, array) else value


_codecs: Final[dict[Any, _Codec]] = {}


def _codec_of(kind: Any) -> _Codec:
    codec = _codecs.get(kind)
    if codec is None:
        codec = _codecs[kind] = _Codec(kind)
    return codec
