"""Messages from and to the bytes of the middleware are the messages that rclpy makes of them."""

from __future__ import annotations

import math
from array import array
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from friction_msgs.msg import BrakeDemand, FrictionCurve, SupervisorState, TyreSignals, Validity, WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header

from friction_runtime.stamps import from_nanoseconds
from friction_runtime.wire import packed, unpacked

HEADER = Header(stamp=from_nanoseconds(1_500_000_007), frame_id="front_left")


def joints(speed: float, *names: str) -> JointState:
    return JointState(header=HEADER, name=names, velocity=[speed] * len(names))


def block(number: int, samples: int) -> TyreSignals:
    voltages = np.sin(np.arange(samples) + number).astype(np.float32)
    return TyreSignals(
        header=HEADER, wheel="front_left", first_sample=number * samples, encoder_voltage=array("f", voltages)
    )


SEQUENCES: list[list[Any]] = [
    [joints(speed, "FL", "rear wheel") for speed in (1.0, math.nan, -0.0)],
    [joints(1.0, "a", "bcd"), joints(2.0, "abc", "d"), joints(3.0, "a", "bcd"), joints(4.0, "ab", "cd")],
    [block(number, samples) for samples in (50, 7, 50) for number in range(3)],
    [BrakeDemand(pressure=pressure) for pressure in (0.0, 1e5, math.inf)],
    [
        WheelSlip(header=HEADER, slip=0.1 * k, validity=Validity(valid=bool(k % 2), text="no speed" * k))
        for k in (0, 1, 1, 2)
    ],
    [FrictionCurve(header=HEADER, theta_covariance=np.arange(9.0) + k) for k in range(3)],
    [SupervisorState(header=HEADER), SupervisorState(header=HEADER)],
    [Imu(header=HEADER, linear_acceleration_covariance=np.arange(9.0) + k) for k in (0, 0, 1)],
    [TwistWithCovarianceStamped(header=HEADER)] * 2,
]


def same(one: Any, other: Any) -> bool:
    """Equal fields, NaN being equal to NaN."""
    if hasattr(other, "get_fields_and_field_types"):
        return all(same(getattr(one, name), getattr(other, name)) for name in other.get_fields_and_field_types())
    if isinstance(other, str | bytes) or not hasattr(other, "__len__"):
        return type(one) is type(other) and (one == other or (one != one and other != other))
    return len(one) == len(other) and all(
        np.asarray(a) == b or (a != a and b != b) for a, b in zip(one, other, strict=True)
    )


@pytest.mark.parametrize("messages", SEQUENCES, ids=lambda messages: type(messages[0]).__name__)
def test_a_message_from_bytes_is_that_of_rclpy_whatever_came_before(messages: list[Any]) -> None:
    kind = type(messages[0])
    for message in messages * 2:
        data = serialize_message(message)
        found = unpacked(data, kind)
        assert isinstance(found, kind)
        assert same(found, deserialize_message(data, kind))


@pytest.mark.parametrize("messages", SEQUENCES, ids=lambda messages: type(messages[0]).__name__)
def test_a_message_to_bytes_is_read_by_rclpy_as_it_was(messages: list[Any]) -> None:
    for message in messages * 2:
        given = packed(message, type(message))
        assert same(deserialize_message(given, type(message)) if isinstance(given, bytes) else given, message)


def test_what_was_taken_from_bytes_can_be_sent_on_in_an_answer() -> None:
    for _ in range(2):
        taken = unpacked(serialize_message(WheelSlip(header=HEADER)), WheelSlip)
    answer = deserialize_message(packed(WheelSlip(header=taken.header, slip=0.2), WheelSlip), WheelSlip)
    assert answer.header == HEADER
    assert serialize_message(taken) == serialize_message(WheelSlip(header=HEADER))


def test_messages_that_hold_messages_in_a_sequence_are_left_to_rclpy() -> None:
    message = DiagnosticArray(status=[DiagnosticStatus(name="wheel")])
    assert packed(message, DiagnosticArray) is message
    assert unpacked(serialize_message(message), DiagnosticArray) == message


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\1\2\3\4" * 5])
def test_bytes_that_are_no_message_are_refused_with_the_name_of_the_type(data: bytes) -> None:
    with pytest.raises(ValueError, match="JointState"):
        unpacked(data, JointState)
    assert unpacked(serialize_message(joints(3.0, "FL")), JointState).velocity[0] == 3.0


def test_a_text_that_is_not_utf_8_is_read_as_rclpy_does() -> None:
    sound = serialize_message(WheelSlip(header=HEADER))
    damaged = sound.replace(b"front", b"fr\xffnt")
    for data in (sound, damaged, sound):
        assert unpacked(data, WheelSlip).header.frame_id == deserialize_message(data, WheelSlip).header.frame_id
