"""An accelerometer that reads no force while all wheels dive is left out; one that is in time is not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator
from wheel_slip.unfelt_dive import UnfeltDive

STEP = 5_000_000
SPEED = 22.0


def braking(time: float) -> float:
    """Acceleration of a car that is braked from 1 s on, full after 0.15 s [m/s^2]."""
    return -9.0 * min(max((time - 1.0) / 0.15, 0.0), 1.0)


def dive(late: float, wheels: Callable[[float, float], list[float]], delay: float = 0.0) -> UnfeltDive:
    """Brake for a second; `wheels` gives the rim speeds by time [s] and speed [m/s]."""
    rng = np.random.default_rng(1)
    watch, speed = UnfeltDive(delay), SPEED
    for number in range(400):
        time = 0.005 * number
        speed += 0.005 * braking(time)
        reading = braking(time - late) + 0.1 * rng.normal()
        watch.update(number * STEP + 1, wheels(time, speed), reading, time < 1.0)
    return watch


def slipping(time: float, speed: float) -> list[float]:
    """Four wheels that slip by what the force asks for on a soft road, more and more."""
    return [speed * (1.0 + 0.02 * braking(time))] * 4


@pytest.mark.parametrize("late", [0.25, 0.4])
def test_one_that_reads_nothing_while_the_wheels_dive_is_left_out_for_half_a_minute(late: float) -> None:
    watch = dive(late, slipping)
    assert watch.holds(2 * NANOSECONDS) and watch.holds(31 * NANOSECONDS)
    assert not watch.holds(33 * NANOSECONDS)


@pytest.mark.parametrize("late", [0.0, 0.03])
def test_one_that_feels_the_brakes_is_used_however_much_the_wheels_slip(late: float) -> None:
    assert not dive(late, slipping).holds(1)
    assert not dive(late, lambda time, speed: [0.0 if time > 1.1 else speed] * 4).holds(1)


def test_one_that_is_late_as_stated_is_used() -> None:
    assert dive(0.25, slipping).holds(1)
    assert not dive(0.25, slipping, delay=0.25).holds(1)


def coasting(wheels: Callable[[float], list[float]]) -> UnfeltDive:
    """Roll without force for two seconds; `wheels` gives the rim speeds by time [s]."""
    watch = UnfeltDive(0.0)
    for number in range(400):
        watch.update(number * STEP + 1, wheels(0.005 * number), 0.0, True)
    return watch


def test_wheels_that_lose_what_others_gain_and_one_that_fails_say_nothing() -> None:
    def curve(time: float) -> list[float]:
        apart = 1.0 * min(max(time - 1.0, 0.0), 1.0)
        return [SPEED - apart, SPEED + apart] * 2

    assert not coasting(curve).holds(1)
    assert not coasting(lambda time: [SPEED, SPEED, SPEED, 0.0 if time > 1.0 else SPEED]).holds(1)
    assert coasting(lambda time: [SPEED - 5.0 * max(time - 1.0, 0.0)] * 3 + [SPEED]).holds(1)


@pytest.mark.parametrize("late", [0.0, 0.1, 0.2, 0.25])
def test_in_a_stop_too_gentle_to_tell_an_age_that_nobody_stated_is_in_the_deviations(late: float) -> None:
    def gentle(time: float) -> float:
        return -6.0 * min(max((time - 3.0) / 0.5, 0.0), 1.0)

    car = load_vehicle("compact_car")
    car = replace(car, accelerometer=replace(car.accelerometer, delay=0.0, deviations={}))
    estimator, rng, speed = SlipEstimator(car), np.random.default_rng(4), 23.0
    inside: list[bool] = []
    while speed > 4.0:
        time = 0.005 * (len(inside) + 1)
        speed += 0.005 * gentle(time)
        slip = -0.006 * gentle(time)
        omega = speed * (1.0 - slip) / np.array(car.radii) + 0.07 * rng.normal(size=4)
        answer = estimator.update(round(time * NANOSECONDS), omega.tolist(), gentle(time - late) + 0.1 * rng.normal())[
            0
        ]
        inside.append(bool(answer.reason) or abs(answer.slip - slip) < 1.96 * answer.slip_variance**0.5)
    assert np.mean(inside[600:]) > 0.9
