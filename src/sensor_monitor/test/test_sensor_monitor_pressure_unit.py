"""A pressure in another unit than Pa is named by how its wheel slows down; no pressure in Pa ever is."""

from collections.abc import Callable

import numpy as np
import pytest

from sensor_monitor.pressure_unit import PressureUnit
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")
WHEEL = CAR.wheel("front_left")
EFFECT = sum(each.brake_gain / each.radius for each in CAR.wheels) / CAR.mass
STEP = 5_000_000


def braked(
    unit: PressureUnit,
    deceleration: float,
    reading: Callable[[float], float],
    rolling: int = 100,
    braking: int = 600,
    speed: float = 25.0,
) -> list[str]:
    """Roll, then brake by `deceleration` [m/s^2]; the sensor reads `reading` of the pressure [Pa]."""
    said = []
    for k in range(rolling + braking):
        pressure = 0.0 if k < rolling else deceleration / EFFECT
        speed = max(speed - pressure * EFFECT * 0.005, 0.0)
        unit.update((k + 1) * STEP, speed / WHEEL.radius, reading(pressure))
        said.append(unit.text)
    return said


@pytest.mark.parametrize("deceleration", [0.5, 2.0, 8.0])
@pytest.mark.parametrize(
    ("factor", "named"), [(1e-5, "in bar"), (1e-6, "in MPa or psi"), (1.45e-4, "in MPa or psi"), (1e5, "once more")]
)
def test_pressure_in_another_unit_is_named_once_the_wheel_has_lost_1_m_s(
    deceleration: float, factor: float, named: str
) -> None:
    said = braked(PressureUnit(CAR, WHEEL.name), deceleration, lambda pressure: factor * pressure)
    first = next(k for k, text in enumerate(said) if text) - 100
    assert first * 0.005 * deceleration == pytest.approx(1.0, abs=0.1)
    assert all(named in text for text in said[first + 100 :])


@pytest.mark.parametrize("deceleration", [0.0, 0.3, 2.0, 8.0])
@pytest.mark.parametrize(
    "reading",
    [
        lambda pressure: pressure,
        lambda pressure: 0.02 * pressure,  # a brake that takes little part
        lambda pressure: 0.0,  # a dead sensor has no unit
        lambda pressure: 40.0,  # nor has one that is stuck
        lambda pressure: pressure - 3e5,
        lambda pressure: float("nan"),
    ],
)
def test_pressure_in_pascals_and_a_dead_sensor_are_never_named(
    deceleration: float, reading: Callable[[float], float]
) -> None:
    assert not any(braked(PressureUnit(CAR, WHEEL.name), deceleration, reading))


def test_a_wheel_that_dives_into_lock_names_no_unit_of_a_noisy_sensor() -> None:
    rng = np.random.default_rng(4)
    assert not any(braked(PressureUnit(CAR, WHEEL.name), 40.0, lambda pressure: pressure + rng.normal(0.0, 3e4)))


def test_a_car_that_rolls_out_without_its_brakes_names_nothing() -> None:
    unit = PressureUnit(CAR, WHEEL.name)
    for k in range(4000):
        unit.update((k + 1) * STEP, (25.0 - 1.2 * 0.005 * k) / WHEEL.radius, 0.0)
        assert not unit.text


def test_a_unit_that_has_shown_does_not_change_on_the_way() -> None:
    unit = PressureUnit(CAR, WHEEL.name)
    braked(unit, 3.0, lambda pressure: pressure)
    assert not any(braked(unit, 3.0, lambda pressure: 1e-5 * pressure))
    unit.reset()
    assert any(braked(unit, 3.0, lambda pressure: 1e-5 * pressure))


def test_single_values_of_another_size_show_no_unit() -> None:
    unit = PressureUnit(CAR, WHEEL.name)
    for k, spike in enumerate((5e6, 2e7, 8e6)):
        unit.update((k + 1) * STEP, 25.0 / WHEEL.radius, spike)
    assert "in bar" in braked(unit, 3.0, lambda pressure: 1e-5 * pressure)[-1]
