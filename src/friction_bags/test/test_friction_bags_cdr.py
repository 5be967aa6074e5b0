import math
import tracemalloc
from array import array
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import (
    BrakeCommand,
    BrakeDemand,
    ContactPatch,
    FrictionCurve,
    FrictionSlope,
    SlopeVote,
    SupervisorState,
    TyreForce,
    TyreSignals,
    WheelSlip,
)
from geometry_msgs.msg import TwistWithCovarianceStamped, WrenchStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import FluidPressure, Imu, JointState
from std_msgs.msg import String

from friction_bags.bag_io.cdr import decode, encode, message_definition, type_name
from friction_runtime.installed import message_class

KINDS: list[Any] = [
    *(BrakeCommand, BrakeDemand, ContactPatch, FrictionCurve, FrictionSlope, SlopeVote, SupervisorState),
    *(TyreForce, TyreSignals, WheelSlip, TwistWithCovarianceStamped, WrenchStamped, FluidPressure, Imu, JointState),
]
RANGES = {"int8": 7, "int16": 15, "int32": 31, "int64": 63}
# a text may hold anything but the zero that ends it in C
TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=12)


def value_of(kind: str, draw: Any) -> Any:
    """A value of a field whose type rclpy names like this."""
    if kind.startswith("sequence<"):
        return [value_of(kind[9:-1], draw) for _ in range(draw(st.integers(0, 5)))]
    if kind.endswith("]"):
        element, count = kind[:-1].split("[")
        return np.array([value_of(element, draw) for _ in range(int(count))])
    if kind == "string":
        return draw(TEXT)
    if kind == "boolean":
        return draw(st.booleans())
    if kind == "double":
        return draw(st.floats())
    if kind == "float":
        return draw(st.floats(width=32))
    if kind.startswith("uint"):
        return draw(st.integers(0, 2 ** int(kind[4:]) - 1))
    if kind in RANGES:
        return draw(st.integers(-(2 ** RANGES[kind]), 2 ** RANGES[kind] - 1))
    return message_of(message_class(kind.replace("/", "/msg/")), draw)


def message_of(kind: Any, draw: Any) -> Any:
    return kind(**{name: value_of(field, draw) for name, field in kind.get_fields_and_field_types().items()})


def same(one: Any, other: Any) -> bool:
    """Equal fields, NaN being equal to NaN, whatever holds them."""
    if hasattr(one, "get_fields_and_field_types"):
        return all(same(getattr(one, name), getattr(other, name)) for name in one.get_fields_and_field_types())
    if is_dataclass(one):
        return all(same(getattr(one, each.name), getattr(other, each.name)) for each in fields(one))
    if isinstance(one, (list, array, np.ndarray)):
        return len(one) == len(other) and all(same(*pair) for pair in zip(one, other, strict=True))
    if isinstance(one, (float, np.floating)) and math.isnan(one):
        return math.isnan(other)
    return one == other and isinstance(one, bool) == isinstance(other, bool)


@settings(max_examples=150)
@given(data=st.data(), kind=st.sampled_from(KINDS))
def test_encoding_and_decoding_agree_with_rclpy(data: st.DataObject, kind: Any) -> None:
    message = message_of(kind, data.draw)
    encoded = encode(message)
    assert same(deserialize_message(encoded, kind), message)
    assert same(message, decode(encoded, kind))
    assert same(message, decode(serialize_message(message), kind))
    assert encode(deserialize_message(serialize_message(message), kind)) == encoded


@settings(max_examples=150)
@given(data=st.data(), kind=st.sampled_from(KINDS), cut=st.floats(0.0, 1.0, exclude_max=True))
def test_cut_off_data_is_refused_with_the_name_of_the_type(data: st.DataObject, kind: Any, cut: float) -> None:
    encoded = encode(message_of(kind, data.draw))
    length = 4 + int(cut * (len(encoded) - 4))
    with pytest.raises(ValueError, match=type_name(kind)):
        decode(encoded[:length], kind)


def test_big_endian_data_is_decoded() -> None:
    assert decode(b"\0\0\0\0\0\0\0\3hi\0", String).data == "hi"


def reading(read: Callable[[], Any]) -> Any:
    """Return the decoded message, or nothing where the data is refused."""
    try:
        return read()
    except (ValueError, SerdeError):
        return None


@settings(max_examples=300)
@given(data=st.data(), kind=st.sampled_from(KINDS))
def test_damaged_data_is_read_as_by_rosbags_whatever_was_read_before(data: st.DataObject, kind: Any) -> None:
    sound = encode(message_of(kind, data.draw))
    damaged = bytearray(sound)
    for _ in range(data.draw(st.integers(1, 3))):
        damaged[data.draw(st.integers(4, len(sound) - 1))] = data.draw(st.integers(0, 255))
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(type_name(kind)).text, type_name(kind)))
    expected = reading(lambda: store.deserialize_cdr(bytes(damaged), type_name(kind)))
    for _ in range(2):
        assert same(store.deserialize_cdr(sound, type_name(kind)), decode(sound, kind))
        found = reading(lambda: decode(bytes(damaged), kind))
        assert expected is None or same(expected, found)


def test_texts_that_exchange_their_lengths_are_told_apart() -> None:
    messages = [JointState(name=["a" * length, "b" * (9 - length)], velocity=[1.0, 2.0]) for length in (2, 7, 2, 4)]
    for message in messages * 3:
        assert same(message, decode(encode(message), JointState))


def test_texts_of_ever_new_lengths_do_not_fill_the_memory() -> None:
    def read_texts() -> int:
        for length in range(3000):
            assert decode(encode(String(data="x" * length)), String).data == "x" * length
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        first = read_texts()
        assert read_texts() - first < 100_000
        assert first < 2_000_000
    finally:
        tracemalloc.stop()
