from math import isclose, pi

import numpy as np
import pytest

from friction_adapter.unit_table import UNITS, conversion, unit_named
from vehicle_models.vehicle import Wheel

WHEEL = Wheel("front_left", "fl", radius=0.3, inertia=1.0, brake_gain=1e-4, encoder_teeth=48)


@pytest.mark.parametrize(
    ("dimension", "unit", "raw", "si"),
    [
        ("wheel_speed", "rad/s", 60.0, 60.0),
        ("wheel_speed", "rpm", 60.0, 2.0 * pi),
        ("wheel_speed", "deg/s", 180.0, pi),
        ("wheel_speed", "km/h", 36.0, 10.0 / 0.3),
        ("wheel_speed", "m/s", 10.0, 10.0 / 0.3),
        ("wheel_speed", "edges/s", 96.0, 4.0 * pi),
        ("pressure", "bar", 80.0, 8e6),
        ("pressure", "psi", 1.0, 6894.757293168),
        ("acceleration", "g", -1.0, -9.80665),
        ("speed", "mph", 100.0, 44.704),
        ("yaw_rate", "deg/s", 90.0, pi / 2.0),
    ],
)
def test_a_value_in_a_unit_becomes_its_si_value(dimension: str, unit: str, raw: float, si: float) -> None:
    assert isclose(conversion(dimension, unit, WHEEL).function()(raw), si, rel_tol=1e-14)


def test_percent_is_a_share_of_the_full_scale() -> None:
    assert conversion("pressure", "%", None, full_scale=1.2e7).function()(50.0) == 6e6


def test_scale_and_offset_make_the_unit_then_the_sign_counts() -> None:
    convert = conversion("acceleration", "g", None, scale=0.01, offset=-1.0, sign=-1).function()
    assert isclose(convert(250.0), -1.5 * 9.80665, rel_tol=1e-14)


def test_a_standard_deviation_has_no_offset() -> None:
    assert isclose(conversion("speed", "km/h", None, offset=5.0, sign=-1).of_difference(3.6), 1.0, rel_tol=1e-14)


def test_a_float32_of_an_array_is_converted_with_all_digits() -> None:
    raw = np.float32(0.1)
    for unit in ("m/s", "km/h"):
        value = conversion("speed", unit, None).function()(raw)  # type: ignore[arg-type]
        assert type(value) is float
        assert value == conversion("speed", unit, None).function()(float(raw))


def test_a_value_in_si_units_keeps_every_bit() -> None:
    assert conversion("speed", "m/s", None).function()(0.1) == 0.1


@pytest.mark.parametrize(
    ("text", "dimension", "name"),
    [
        ("kph", "speed", "km/h"),
        ("KM/H", "speed", "km/h"),
        ("1/min", "wheel_speed", "rpm"),
        ("m/s²", "acceleration", "m/s^2"),
        ("BAR", "pressure", "bar"),
        ("MPa", "pressure", "MPa"),
        ("mPa", "pressure", None),
        ("bar", "speed", None),
        ("", "speed", None),
        ("1/s", "wheel_speed", None),
    ],
)
def test_spellings_of_a_unit(text: str, dimension: str, name: str | None) -> None:
    assert unit_named(text, dimension) == name


def test_the_si_unit_comes_first() -> None:
    assert all(next(iter(units.values())) == 1.0 for units in UNITS.values())
