"""Stamps are exact."""

from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st

from friction_runtime.messages import from_nanoseconds, to_nanoseconds


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999))
def test_a_stamp_survives_the_way_to_nanoseconds_and_back(sec: int, nanosec: int) -> None:
    stamp = Time(sec=sec, nanosec=nanosec)
    assert from_nanoseconds(to_nanoseconds(stamp)) == stamp
