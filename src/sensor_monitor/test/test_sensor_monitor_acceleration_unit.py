"""An accelerometer in g, or mounted the wrong way round, is named by how the wheels change their speed."""

from collections.abc import Callable
from math import inf, pi, sin

import numpy as np
import pytest
from numpy.typing import NDArray

from sensor_monitor.acceleration_unit import AccelerationUnit

Array = NDArray[np.float64]
DT = 0.005
STEP = 5_000_000
IN_G = 1.0 / 9.81


def texts(unit: AccelerationUnit, speeds: Array, readings: Array) -> list[str]:
    found = []
    for k, (speed, reading) in enumerate(zip(speeds.tolist(), readings.tolist(), strict=True)):
        unit.update((k + 1) * STEP, speed, reading)
        found.append(unit.text)
    return found


def drive(acceleration: Callable[[float], float], seconds: float = 6.0) -> tuple[Array, Array]:
    """Speeds with the noise of one encoder, and accelerations with that of an accelerometer, from 25 m/s."""
    rng = np.random.default_rng(1)
    times = DT * np.arange(round(seconds / DT))
    true = np.array([acceleration(time) for time in times])
    speeds = 25.0 + np.concatenate(([0.0], np.cumsum(true[1:] * DT)))
    return speeds + rng.normal(0.0, 0.02, len(times)), true + rng.normal(0.0, 0.1, len(times))


def gentle(time: float) -> float:
    return -2.0 * min(max(time - 1.0, 0.0), 1.0)


@pytest.mark.parametrize("offset", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize(("factor", "named"), [(IN_G, "in g"), (-1.0, "sign")])
def test_another_unit_or_sign_is_named_in_gentle_braking_whatever_the_offset(
    factor: float, named: str, offset: float
) -> None:
    speeds, readings = drive(gentle)
    found = texts(AccelerationUnit(), speeds, factor * readings + offset)
    assert named in found[round(2.5 / DT)]
    assert all(named in text for text in found[round(2.5 / DT) :])


@pytest.mark.parametrize("offset", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize(
    "acceleration",
    [
        gentle,
        lambda time: -8.0 * (time > 1.0) * (time < 3.0),
        lambda time: 1.5 * sin(time),
        lambda time: 0.0,
    ],
)
def test_an_accelerometer_that_is_right_is_never_named(acceleration: Callable[[float], float], offset: float) -> None:
    speeds, readings = drive(acceleration)
    assert not any(texts(AccelerationUnit(), speeds, readings + offset))


def test_a_car_that_coasts_over_hills_is_not_named_though_the_sensor_reads_nothing() -> None:
    speeds, _ = drive(lambda time: 1.0 * sin(2.0 * pi * time / 8.0), 40.0)
    readings = np.random.default_rng(2).normal(-0.2, 0.1, len(speeds))
    assert not any(texts(AccelerationUnit(), speeds, readings))


def test_wheels_that_dive_on_ice_while_the_car_hardly_slows_down_name_nothing() -> None:
    """The speed is that of the wheels: it falls thirty times as fast as that of the car, and comes back."""
    times = DT * np.arange(800)
    dive = np.where(times > 1.0, np.abs(((times - 1.0) % 0.6) - 0.3) * 30.0 - 9.0, 0.0)
    noise = np.random.default_rng(3)
    speeds = 25.0 - 0.5 * np.maximum(times - 1.0, 0.0) + dive + noise.normal(0.0, 0.02, 800)
    readings = -0.5 * (times > 1.0) + noise.normal(0.0, 0.1, 800)
    assert not any(texts(AccelerationUnit(), speeds, readings))


def test_the_wrong_sign_is_named_within_wheels_that_dive() -> None:
    speeds, readings = drive(lambda time: -30.0 * (time > 1.0) * (time < 1.6))
    assert "sign" in texts(AccelerationUnit(), speeds, -0.05 * readings)[-1]


def test_a_speed_without_wheels_that_slip_names_the_unit_in_hard_braking_too() -> None:
    speeds, readings = drive(lambda time: -8.0 * min(max((time - 1.0) / 0.2, 0.0), 1.0) * (time < 3.0))
    assert "in g" in texts(AccelerationUnit(largest=inf), speeds, IN_G * readings)[-1]
    assert not any(texts(AccelerationUnit(largest=inf), speeds, readings))


def test_what_has_agreed_is_not_suspected_until_a_reset() -> None:
    unit = AccelerationUnit()
    speeds, readings = drive(gentle)
    assert not any(texts(unit, speeds, readings))
    assert unit.known
    assert not any(texts(unit, speeds, -readings))
    unit.reset()
    assert any(texts(unit, speeds, -readings))
