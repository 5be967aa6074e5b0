"""Messages to CDR and back.

rclpy's own serialization does not initialise the padding between fields, and appends padding to a message that ends
with an empty sequence of doubles; rosbags pads with zeros and appends nothing, so that equal messages give equal bytes.
Its decoding takes half the time of rclpy's, which is kept for messages with that padding: rosbags refuses them. A
message with the same lengths as an earlier one is read and written by its layout, with the same bytes and values as by
rosbags in a fraction of the time.
"""

from array import array
from collections.abc import Callable
from contextlib import suppress
from operator import attrgetter
from typing import Any, Final

import numpy as np
from rclpy.serialization import deserialize_message
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.cdr_layout import HEADER, Layout, Message, UnsupportedFieldError
from friction_bags.bag_io.message_definition import message_definition, type_name

_LENGTH_SIZE: Final = 4
_MOST_LAYOUTS: Final = 64
"""Most layouts kept of one class before all are dropped, so that strings of ever new lengths do not fill the memory."""


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
        self._layouts: dict[tuple[int, ...], Layout] = {}
        self._first_length = 0
        self._tried: dict[tuple[int, bytes], Layout] = {}
        """The layout that fitted last, by size and first length of the data."""
        self._message: Message | None = None
        self._values_of: Callable[[Any], tuple[Any, ...]] | None = None
        self._texts: list[int] = []
        with suppress(UnsupportedFieldError):
            self._message = Message(kind)
            slots = list(self._message.written_slots())
            self._texts = [index + 1 for index in range(1, len(slots)) if slots[index] == slots[index - 1]]
            """Places of the texts in Layout.write."""
            if len(slots) > 1:
                self._values_of = attrgetter(*slots)

    def encode(self, message: Any) -> bytes:
        if self._values_of is None or self._message is None:
            return bytes(self._store.serialize_cdr(_Numpy(message), self._name))
        values = [HEADER, *self._values_of(message)]
        lengths = []
        for index in self._texts:
            text = values[index].encode()
            length = len(text) + 1
            values[index - 1] = length
            values[index] = text
            lengths.append(length)
        return self._layout(self._message, tuple(lengths)).write(values)

    def decode(self, data: bytes) -> Any:
        known = self._tried.get(self._key(data))
        if known is not None:
            message = self._read(known, data)
            if message is not None:
                return message
        try:
            message = self._store.deserialize_cdr(data, self._name)
        except SerdeError:
            return self._decode_padded(data)
        if self._message is not None:
            layout = self._layout(self._message, tuple(self._message.lengths(message)))
            if layout.size == len(data):
                self._first_length = layout.first_length
                self._tried[self._key(data)] = layout
        return message

    def _key(self, data: bytes) -> tuple[int, bytes]:
        return len(data), data[self._first_length : self._first_length + _LENGTH_SIZE]

    def _read(self, layout: Layout, data: bytes) -> Any:
        try:
            return layout.read(data)
        except ValueError:
            return None

    def _layout(self, message: Message, lengths: tuple[int, ...]) -> Layout:
        layout = self._layouts.get(lengths)
        if layout is None:
            if len(self._layouts) == _MOST_LAYOUTS:
                self._layouts.clear()
                self._tried.clear()
            layout = self._layouts[lengths] = Layout(message, lengths, self._store.types)
        return layout

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
