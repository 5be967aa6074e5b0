"""Messages to CDR and back, several times as fast as rclpy, for offline work.

rclpy's own serialization leaves the padding between fields as it finds it in memory, and appends padding to a message
that ends with an empty sequence of doubles. Both decode to the same message. Here padding is zero, nothing is added:
the same message always gives the same bytes.
"""

from array import array
from collections.abc import Callable
from functools import cache
from operator import attrgetter
from struct import Struct
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message

from friction_bags.bag_format import Topic
from friction_bags.cdr_layout import (
    FixedArray,
    Item,
    Layout,
    Numbers,
    NumberSequence,
    Shape,
    Text,
    UnsupportedLayoutError,
    layout_of,
)
from friction_bags.message_definition import message_definition

_LITTLE_ENDIAN = b"\0\1\0\0"
_START = len(_LITTLE_ENDIAN)
_LENGTH = Struct("<I")

_Step = Callable[[bytes, int, list[Any]], int]
"""Reads an item from CDR at a position, appends its values, returns the position behind it."""


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
        UnsupportedLayoutError: the class has fields that are not covered, such as sequences of messages.
    """
    kind: Any = type(message)
    return _encoder(kind)(message)


def decode(data: bytes, kind: Any) -> Any:
    """Message of a class from CDR.

    Raises:
        ValueError: the data is no message of this class.
    """
    read = _decoder(kind)
    if read is None or data[:_START] != _LITTLE_ENDIAN:
        return deserialize_message(data, kind)
    return read(data)


@cache
def _encoder(kind: Any) -> Callable[[Any], bytes]:
    layout = layout_of(kind)
    values_of = attrgetter(*layout.paths) if len(layout.paths) > 1 else _single(layout.paths[0])
    writers = [_writer(item) for item in layout.items]

    def encode_message(message: Any) -> bytes:
        values = values_of(message)
        parts = [_LITTLE_ENDIAN]
        position = index = 0
        for write, count in writers:
            part = write(values[index : index + count], position)
            parts.append(part)
            position += len(part)
            index += count
        return b"".join(parts)

    return encode_message


def _single(path: str) -> Callable[[Any], tuple[Any]]:
    get = attrgetter(path)
    return lambda message: (get(message),)


def _writer(item: Item) -> tuple[Callable[[Any, int], bytes], int]:
    """What writes an item's values behind a position, and how many they are."""
    if isinstance(item, Numbers):
        structs = item.structs()
        return lambda values, position: structs[position & 7].pack(*values), len(item.codes)
    if isinstance(item, Text):
        return lambda values, position: _text(values[0], position), 1
    if isinstance(item, FixedArray):
        structs = Numbers(item.code * item.count).structs()
        return lambda values, position: structs[position & 7].pack(*values[0]), 1
    if isinstance(item, NumberSequence):
        return lambda values, position: _sequence(item, values[0], position), 1
    return lambda values, position: _texts(values[0], position), 1


def _text(value: str, position: int) -> bytes:
    data = value.encode() + b"\0"
    return b"\0" * (-position & 3) + _LENGTH.pack(len(data)) + data


def _texts(values: list[str], position: int) -> bytes:
    data = b"\0" * (-position & 3) + _LENGTH.pack(len(values))
    for value in values:
        data += _text(value, position + len(data))
    return data


def _sequence(item: NumberSequence, values: Any, position: int) -> bytes:
    head = b"\0" * (-position & 3) + _LENGTH.pack(len(values))
    if not len(values):
        return head
    return head + b"\0" * (-(position + len(head)) % item.size) + array(item.code, values).tobytes()


@cache
def _decoder(kind: Any) -> Callable[[bytes], Any] | None:
    """What reads messages of a class; None where its layout is not covered."""
    try:
        layout = layout_of(kind)
    except UnsupportedLayoutError:
        return None
    return _reader(layout)


def _reader(layout: Layout) -> Callable[[bytes], Any]:
    steps = [_step(item) for item in layout.items]
    shape = layout.shape
    name = type_name(shape.kind)

    def decode_message(data: bytes) -> Any:
        values: list[Any] = []
        position = _START
        try:
            for step in steps:
                position = step(data, position, values)
        except Exception as error:
            raise ValueError(f"not a {name}: {error}") from error
        return _built(shape, values)

    return decode_message


def _built(shape: Shape, values: list[Any]) -> Any:
    message = shape.kind.__new__(shape.kind)
    message._check_fields = False
    for slot, index in shape.values:
        setattr(message, slot, values[index])
    for slot, inner in shape.messages:
        setattr(message, slot, _built(inner, values))
    return message


def _step(item: Item) -> _Step:
    if isinstance(item, Numbers):
        return _read_numbers(item)
    if isinstance(item, Text):
        return _read_text
    if isinstance(item, FixedArray):
        return _read_array(item)
    if isinstance(item, NumberSequence):
        return _read_sequence(item)
    return _read_texts


def _read_numbers(item: Numbers) -> _Step:
    structs = item.structs()

    def step(data: bytes, position: int, values: list[Any]) -> int:
        run = structs[(position - _START) & 7]
        values += run.unpack_from(data, position)
        return position + run.size

    return step


def _read_text(data: bytes, position: int, values: list[Any]) -> int:
    position += -position & 3
    (length,) = _LENGTH.unpack_from(data, position)
    end = position + 4 + length
    if end > len(data):
        raise ValueError("a text is cut off")
    values.append(str(data[position + 4 : end - 1], "utf-8"))
    return end


def _read_texts(data: bytes, position: int, values: list[Any]) -> int:
    position += -position & 3
    (count,) = _LENGTH.unpack_from(data, position)
    position += 4
    texts: list[Any] = []
    for _ in range(count):
        position = _read_text(data, position, texts)
    values.append(texts)
    return position


def _read_array(item: FixedArray) -> _Step:
    structs = Numbers(item.code * item.count).structs()
    kind = np.dtype(item.code)

    def step(data: bytes, position: int, values: list[Any]) -> int:
        run = structs[(position - _START) & 7]
        values.append(np.array(run.unpack_from(data, position), kind))
        return position + run.size

    return step


def _read_sequence(item: NumberSequence) -> _Step:
    def step(data: bytes, position: int, values: list[Any]) -> int:
        position += -position & 3
        (count,) = _LENGTH.unpack_from(data, position)
        position += 4
        if count:
            position += -(position - _START) % item.size
        end = position + count * item.size
        if end > len(data):
            raise ValueError("a sequence is cut off")
        numbers = array(item.code)
        numbers.frombytes(data[position:end])
        values.append(numbers)
        return end

    return step
