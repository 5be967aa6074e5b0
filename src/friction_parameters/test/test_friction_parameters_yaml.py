"""Scalars of YAML: read as by the parser of ROS, and written so that both read them in the same way."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_parameters.parameter import ParameterError
from friction_parameters.yaml_file import read_value, yaml_text


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("-0", 0),
        ("+7", 7),
        ("1.", 1.0),
        (".5", 0.5),
        ("1e-4", 1e-4),
        ("1.0E5", 1e5),
        ("-.inf", -math.inf),
        ("99999999999999999999", 1e20),
        ("1_000", "1_000"),
        ("1:30", "1:30"),
        ("2024-01-01", "2024-01-01"),
        ("'5'", "5"),
        ('"true"', "true"),
        ("True", True),
        ("NO", False),
        ("y", "y"),
        ("~", None),
        ("", None),
        ("[0, 40.5]", [0, 40.5]),
        ("{a: [1, b]}", {"a": [1, "b"]}),
        ("/a/b c.yaml", "/a/b c.yaml"),
    ],
)
def test_values_are_read_with_their_types(text: str, value: Any) -> None:
    found = read_value(text)
    assert found == value
    assert type(found) is type(value)


def test_not_a_number_is_read() -> None:
    assert math.isnan(read_value(".nan"))


def test_a_value_that_is_no_yaml_is_refused() -> None:
    with pytest.raises(ParameterError, match="not YAML"):
        read_value("[1, 2")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e-4, "0.0001"),
        (1e-7, "1.0e-07"),
        (1e22, "1.0e+22"),
        (2.0, "2.0"),
        (-math.inf, "-.inf"),
        (math.nan, ".nan"),
        (7, "7"),
        (True, "true"),
        (None, "null"),
        ("no_slip", '"no_slip"'),
        ((0.0, 40.5), "[0.0, 40.5]"),
        (("a", "b"), '["a", "b"]'),
    ],
)
def test_values_are_written_in_one_line(value: Any, text: str) -> None:
    assert yaml_text(value) == text


@given(
    st.one_of(
        st.floats(allow_nan=False),
        st.integers(-(10**17), 10**17),
        st.booleans(),
        st.text(st.characters(exclude_categories=["Cs"])),
        st.lists(st.floats(allow_nan=False), min_size=1),
        st.lists(st.text(st.characters(exclude_categories=["Cs"])), min_size=1),
    )
)
def test_what_is_written_is_read_back(value: Any) -> None:
    written = yaml_text(value)
    assert "\n" not in written
    assert read_value(written) == value
    assert type(read_value(written)) is type(value)
