"""A speed sensor and wheels that agree outvote the accelerometer; either of them alone does not."""

import numpy as np
import pytest

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator
from wheel_slip.outvoted import Outvoted
from wheel_slip.speed_sample import SpeedSample

STEP = 5_000_000
CAR = load_vehicle("compact_car")
NOISE = 0.25


def votes(from_speed: float, from_wheels: float | None, seconds: float, rate: float = 25.0) -> Outvoted:
    """Return the count of a sensor that differs by so much [m/s] from the speed and from the wheels."""
    rng = np.random.default_rng(2)
    counted = Outvoted()
    for number in range(round(seconds * rate)):
        noise = NOISE**0.5 * rng.normal()
        wheels = None if from_wheels is None else (from_wheels + noise, 1e-4)
        counted.note(round((number + 1) / rate * NANOSECONDS), NOISE, (from_speed + noise, 1e-4), wheels)
    return counted


@pytest.mark.parametrize("rate", [10.0, 25.0, 100.0])
def test_a_difference_from_the_speed_alone_leaves_the_accelerometer_out_for_half_a_minute(rate: float) -> None:
    counted = votes(1.5, 0.0, 3.0, rate)
    assert counted.holds(4 * NANOSECONDS) and counted.holds(31 * NANOSECONDS)
    assert not counted.holds(34 * NANOSECONDS)


@pytest.mark.parametrize(("from_speed", "from_wheels"), [(0.0, 0.0), (1.5, 1.5), (0.0, 1.5), (1.5, None)])
def test_agreement_wheels_that_slide_a_wrong_sensor_and_wheels_unlike_leave_it_in(
    from_speed: float, from_wheels: float | None
) -> None:
    assert not votes(from_speed, from_wheels, 60.0).holds(60 * NANOSECONDS)


def test_samples_far_apart_are_not_averaged() -> None:
    assert not votes(1.5, 0.0, 60.0, rate=1.0).holds(60 * NANOSECONDS)


def run(reading: float, slip: float = 0.0) -> tuple[SlipEstimator, float, float]:
    """Drive 10 s at 15 m/s, then brake by 3 m/s^2 with an accelerometer that reads otherwise.

    Returns the estimator, the largest error of the speed after a second of braking [m/s], and the largest over its
    deviation.
    """
    rng = np.random.default_rng(4)
    estimator, speed, errors, z = SlipEstimator(CAR), 15.0, [0.0], [0.0]
    for number in range(2600):
        braking = number > 2000
        speed -= 0.015 if braking else 0.0
        stamp = (number + 1) * STEP
        wheels = speed * (1.0 - slip * braking) / 0.3 + 0.07 * rng.normal(size=4)
        sensor = [SpeedSample(stamp, speed + 0.1 * rng.normal(), 0.01)] if number % 8 == 0 else []
        measured = (reading if braking else 0.0) + 0.1 * rng.normal()
        estimate = estimator.update(stamp, wheels.tolist(), measured, sensor)[0]
        if number > 2200 and estimate.reason is Reason.OK:
            errors.append(abs(estimate.vehicle_speed - speed))
            z.append(errors[-1] / estimate.vehicle_speed_variance**0.5)
    return estimator, max(errors), max(z)


@pytest.mark.parametrize(("reading", "named"), [(-1.0, "speed sensor and the wheels"), (0.0, "no force")])
def test_one_that_reads_too_little_in_a_braking_is_named_and_the_speed_is_the_sensors(
    reading: float, named: str
) -> None:
    estimator, error, z = run(reading)
    assert named in estimator.vehicle.accelerometer_text
    assert error < 0.5 and z < 4.0


def test_a_healthy_one_is_not_named_whether_the_wheels_roll_or_slide() -> None:
    for slip in (0.01, 0.15):
        estimator, error, z = run(reading=-3.0, slip=slip)
        assert estimator.vehicle.accelerometer_text == ""
        assert error < 0.3 and z < 4.0


def test_radii_that_are_wrong_alike_are_in_the_deviation_of_slip_or_speed_whatever_the_speed_is_made_of() -> None:
    car = load_vehicle("indy_av21")
    for sensor_stddev in (None, 2.0, 0.02):
        estimator = SlipEstimator(car)
        for number in range(2000):
            stamp = (number + 1) * STEP
            noise = np.random.default_rng(number)
            wheels = 20.0 / (0.99 * 0.3) + 0.07 * noise.normal(size=4)
            sensor = []
            if sensor_stddev is not None and number % 8 == 0:
                sensor = [SpeedSample(stamp, 20.0 + sensor_stddev * noise.normal(), sensor_stddev**2)]
            estimate = estimator.update(stamp, wheels.tolist(), 0.1 * noise.normal(), sensor)[0]
        assert abs(estimate.vehicle_speed - 20.0) < 2.5 * estimate.vehicle_speed_variance**0.5
        assert abs(estimate.slip) < 2.5 * estimate.slip_variance**0.5
