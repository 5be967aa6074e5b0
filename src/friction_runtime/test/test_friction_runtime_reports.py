"""Reports that differ only in values from a message are of one kind, and a kind is logged at a limited rate."""

import pytest

from friction_runtime.reports import ReportLimit, report_kind


@pytest.mark.parametrize("value", [5.0, -3.25e-7, 1e300, float("nan"), float("inf"), float("-inf"), 17, 0.1 + 0.2])
def test_numbers_make_no_new_kind(value: float) -> None:
    text = "front_left/brake_pressure: {} Pa is not a brake pressure: refused"
    assert report_kind(text.format(value)) == report_kind(text.format(1.0))


def test_strings_of_a_message_make_no_new_kind() -> None:
    text = "wheel_states: no velocity for wheel 'FL', names are: \"{}\"; check the vehicle file"
    assert report_kind(text.format("a, b")) == report_kind(text.format("")) == report_kind(text.format("c 3"))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("wheel_1/slip: stamp repeats", "wheel_2/slip: stamp repeats"),
        ("no velocity for wheel '1'", "no velocity for wheel '2'"),
        ("velocity of wheel 'FL' is not a wheel speed: 3.0", "velocity of wheel 'FR' is not a wheel speed: 3.0"),
        ("imu/data: stamp is zero", "imu/data: stamp repeats"),
        ("there is information", "there is #rmation"),
    ],
)
def test_wheels_and_causes_are_kinds_of_their_own(one: str, other: str) -> None:
    assert report_kind(one) != report_kind(other)


def test_a_kind_passes_once_in_five_seconds_whatever_its_values() -> None:
    limit = ReportLimit()
    passed = [k for k in range(2200) if limit.passes(f"imu/data: {k * 0.1} is no acceleration", k * 0.005)]
    assert passed == [0, 1000, 2000]


def test_kinds_do_not_hold_each_other_back() -> None:
    limit = ReportLimit()
    assert [limit.passes(f"{topic}: stamp repeats", 1.0) for topic in ("a", "b", "a")] == [True, True, False]


def test_memory_is_bounded_where_every_text_is_a_kind() -> None:
    limit = ReportLimit()
    assert all(limit.passes(f"topic_{k}: bad", 0.0) for k in range(5000))
    assert not limit.passes("topic_4999: bad", 1.0)
