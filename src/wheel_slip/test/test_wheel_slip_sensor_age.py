"""A speed sensor that is old at its stamps, as a logged satellite receiver is, is named and not used."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimate import SpeedSource, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.speed_sample import SpeedSample

STEP = 0.01
DURATION = 40.0
CAR = load_vehicle("compact_car")
DRIVES_ALL = replace(CAR, wheels=tuple(replace(wheel, driven=True) for wheel in CAR.wheels))


def speed_at(t: float) -> float:
    """Speed of a drive in traffic, up to 1.6 m/s^2 [m/s]."""
    return 15.0 + 5.0 * float(np.sin(2.0 * pi * t / 20.0))


def drive(
    age: float, held: float, *, compliance: float = 0.008, car: Vehicle = CAR, gauged: bool = True
) -> list[tuple[float, WheelEstimate, str]]:
    """Drive with a speed that is `age` old when it comes, every `held` seconds, and is in every row until the next."""
    rng = np.random.default_rng(8)
    estimator = SlipEstimator(car)
    radii = np.array(car.radii)
    found = []
    for k in range(1, round(DURATION / STEP)):
        t, stamp = k * STEP, round(k * STEP * 1e9)
        speed = speed_at(t)
        a = (speed_at(t + 1e-3) - speed_at(t - 1e-3)) / 2e-3
        slips = np.array([compliance * -a if a < 0.0 or wheel.driven else 0.0 for wheel in car.wheels])
        omega = speed * (1.0 - slips) / radii + 0.05 * rng.normal(size=4)
        told = speed_at(held * np.floor(t / held) - age)
        row = estimator.update(
            stamp, omega.tolist(), a + 0.1 * rng.normal() if gauged else None, [SpeedSample(stamp, told, 0.01)]
        )
        found.append((speed, row[0], estimator.vehicle.sensor_text))
    return found


def covered(found: list[tuple[float, WheelEstimate, str]]) -> float:
    """Share of the valid answers whose speed is within two of its deviations."""
    valid = [(speed, each) for speed, each, _ in found if each.reason is Reason.OK]
    assert len(valid) > 0.9 * len(found)
    return float(
        np.mean([abs(each.vehicle_speed - speed) < 2.0 * each.vehicle_speed_variance**0.5 for speed, each in valid])
    )


@pytest.mark.parametrize(
    ("age", "held", "gauged"),
    [(0.5, 0.1, True), (1.0, 0.1, True), (0.8, 1.0, True), (1.5, 0.1, True), (1.0, 0.1, False)],
)
def test_an_old_speed_is_named_with_its_age_and_the_wheels_go_on_without_it(
    age: float, held: float, gauged: bool
) -> None:
    found = drive(age, held, gauged=gauged)
    assert covered(found) > 0.95
    late = found[len(found) // 2 :]
    assert all("left out" in text for _, _, text in late)
    ages = [float(text.split()[1]) for _, _, text in late if "behind" in text]
    assert 0.6 < np.mean(ages) / (age + 0.5 * held) < 1.2
    assert {each.source for _, each, _ in late} <= {SpeedSource.WHEELS, SpeedSource.INTEGRATED}


@pytest.mark.parametrize("car", [CAR, DRIVES_ALL], ids=["one axle", "all wheels"])
@pytest.mark.parametrize("compliance", [0.004, 0.03])
def test_slip_that_grows_with_the_acceleration_is_never_taken_for_an_age(compliance: float, car: Vehicle) -> None:
    found = drive(0.0, STEP, compliance=compliance, car=car)
    assert {text for _, _, text in found} == {""}
    assert found[-1][1].source is SpeedSource.SENSOR
    assert covered(found) > 0.95
