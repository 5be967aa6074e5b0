"""A speed sensor that is late in a hard stop is counted, found beside the accelerometer, and left out."""

from functools import cache

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimate import SpeedSource, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.sensor_skew import SensorSkew
from wheel_slip.speed_sample import SpeedSample

STEP = 5_000_000
CAR = load_vehicle("compact_car")
ONSET = 2.5
STRONG = 7.0
DURATION = 5.0
UNKNOWN = 0.07


def speed_at(t: float) -> float:
    """25 m/s, and a brake that is applied within 0.3 s [m/s]."""
    since = max(t - ONSET, 0.0)
    return 25.0 - STRONG * (0.5 * min(since, 0.3) ** 2 / 0.3 + max(since - 0.3, 0.0))


@cache
def stop(age: float) -> list[tuple[float, WheelEstimate, str]]:
    """Stop with a sensor at 20 Hz that is `age` old at its stamps: true speed, answer, what is said of the sensor."""
    rng = np.random.default_rng(12)
    estimator = SlipEstimator(CAR)
    found = []
    for k in range(1, round(DURATION / 0.005)):
        t = 0.005 * k
        speed = speed_at(t)
        a = (speed_at(t + 1e-3) - speed_at(t - 1e-3)) / 2e-3
        omega = speed * (1.0 + 0.008 * a) / 0.3 + 0.07 * rng.normal(size=4)
        told = speed_at(t - age) + 0.1 * rng.normal()
        measured = [SpeedSample(k * STEP, told, 0.01)] if k % 10 == 0 else []
        row = estimator.update(k * STEP, omega.tolist(), a + 0.1 * rng.normal(), measured)
        found.append((speed, row[0], estimator.vehicle.sensor_text))
    return found


@pytest.mark.parametrize("age", [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0])
def test_the_stated_deviation_holds_from_the_first_hard_stop_on_however_late_the_sensor_is(age: float) -> None:
    valid = [(speed, each) for speed, each, _ in stop(age) if not each.reason]
    z = [(each.vehicle_speed - speed) / each.vehicle_speed_variance**0.5 for speed, each in valid]
    assert len(valid) > 0.9 * len(stop(age))
    assert np.sqrt(np.mean(np.square(z))) < 1.3
    assert np.mean(np.abs(z) < 1.96) > 0.95


@pytest.mark.parametrize("age", [0.3, 0.5, 1.0])
def test_a_late_sensor_is_named_within_the_stop_and_takes_its_error_with_it(age: float) -> None:
    end = stop(age)[-100:]
    assert all("behind the accelerometer; left out" in text for _, _, text in end)
    assert {each.source for _, each, _ in end} <= {SpeedSource.WHEELS, SpeedSource.INTEGRATED}
    assert max(abs(each.vehicle_speed - speed) for speed, each, _ in end) < 0.1 * STRONG * age + 0.3


def test_a_sensor_in_time_is_known_to_be_after_one_braking_and_is_used_as_well_as_before() -> None:
    found = stop(0.0)
    assert {text for _, _, text in found} == {""}
    assert all(each.source is SpeedSource.SENSOR for _, each, _ in found[20:])
    end = [(speed, each) for speed, each, _ in found[-200:]]
    assert max(each.vehicle_speed_variance**0.5 for _, each in end) < 0.25
    assert np.sqrt(np.mean([(each.vehicle_speed - speed) ** 2 for speed, each in end])) < 0.06


def compared(age: float, accelerations: list[float], slope: list[float] | None = None) -> SensorSkew:
    """Compare 1 s of each of some accelerations with a sensor of an age; `slope`: what the road adds to the reading."""
    skew, rng = SensorSkew(UNKNOWN), np.random.default_rng(3)
    rates = np.repeat(accelerations, 200)
    way = np.cumsum(rates + np.repeat(slope or [0.0] * len(accelerations), 200)) * 0.005
    # Before its first sample the car has had the first acceleration.
    speeds = np.cumsum(np.concatenate([np.repeat(accelerations[0], 400), rates])) * 0.005
    for k, travelled in enumerate(way):
        skew.follow(k * STEP, float(travelled))
        if k % 10 == 0:
            told = speeds[400 + k - round(age / 0.005)]
            skew.update(k * STEP, float(told + 0.1 * rng.normal()), 0.01)
    return skew


def test_a_car_that_keeps_its_acceleration_says_nothing_of_the_age() -> None:
    """A deviation of the age, as far as the ages to expect have one, remains."""
    fresh, skew = SensorSkew(UNKNOWN), compared(0.3, [-2.0] * 6)
    for k in range(400):
        fresh.follow(k * STEP, -2.0 * 0.005 * k)
    assert skew.late == 0.0
    assert skew.spread == pytest.approx(fresh.spread, rel=0.2)


@pytest.mark.parametrize("strong", [-4.0, -8.0, 3.0])
def test_one_change_of_acceleration_shows_the_age(strong: float) -> None:
    in_time, late = compared(0.0, [0.0, 0.0, strong, strong]), compared(0.45, [0.0, 0.0, strong, strong])
    assert in_time.late == 0.0
    assert in_time.variance(strong) < (0.04 * strong) ** 2
    assert late.late == pytest.approx(0.45, abs=0.1)


@pytest.mark.parametrize("step", [-1.0, 1.0])
def test_a_step_of_slope_in_a_braking_does_not_pass_for_an_age(step: float) -> None:
    skew = compared(0.0, [0.0, 0.0, -6.0, -6.0, -6.0, -6.0], [0.0, 0.0, 0.0, step, step, step])
    assert skew.late == 0.0
    assert skew.variance(-6.0) < (UNKNOWN * 6.0) ** 2
