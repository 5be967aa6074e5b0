"""Radius errors as states of the filter: learned on the way, apart from curves and slips."""

from dataclasses import replace

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimate import SpeedSample, WheelEstimate
from wheel_slip.estimator import SlipEstimator

STEP = 5_000_000
CAR = load_vehicle("compact_car")
SIDES = np.array([-1.0, 1.0, -1.0, 1.0])
AHEAD = CAR.wheelbase * np.array([1.0, 1.0, 0.0, 0.0])
"""Of the middle of the rear axle [m]."""


def drive(
    estimator: SlipEstimator,
    shares: list[float],
    *,
    metres: float,
    speed: float = 22.0,
    curvature: float = 0.0,
    force: float = 0.0,
    slips: tuple[float, ...] = (0.0,) * 4,
) -> list[WheelEstimate]:
    """Roll at a constant speed with radii that differ from the file's by `shares`; return the last estimates."""
    rng = np.random.default_rng(3)
    radii = np.array(CAR.radii) * (1.0 + np.array(shares))
    ground = speed * np.hypot(1.0 + SIDES * curvature * CAR.track / 2.0, AHEAD * curvature)
    true = ground * (1.0 - np.array(slips)) / radii
    row: list[WheelEstimate] = []
    for k in range(1, round(metres / speed / 0.005)):
        omega = true + 0.07 * rng.normal(size=4)
        row = estimator.update(k * STEP, omega.tolist(), force + 0.1 * rng.normal())
    return row


def apart(estimator: SlipEstimator) -> float:
    """Standard deviation of the difference of the radii of both front wheels, as a share."""
    p = estimator.car.covariance[-4:, -4:]
    return float(np.sqrt(p[0, 0] + p[1, 1] - 2.0 * p[0, 1]))


@pytest.mark.parametrize(("speed", "metres"), [(22.0, 300.0), (35.0, 900.0)])
@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("error", [-0.05, 0.05])
def test_one_wheel_far_off_its_file_is_found_named_and_corrected(
    wheel: int, speed: float, metres: float, error: float
) -> None:
    """At 126 km/h the air takes so much that a driven wheel may as well slip on ice: that needs more time."""
    estimator = SlipEstimator(CAR)
    shares = [0.0] * 4
    shares[wheel] = error
    row = drive(estimator, shares, metres=metres, speed=speed)
    found, stddevs = estimator.car.radius_errors
    assert found == pytest.approx(shares, abs=0.006 if speed < 30.0 else 0.01)
    assert np.all(np.abs(found - shares) < 2.0 * stddevs)
    assert estimator.car.another_tyre[wheel] > 0.9
    assert estimator.radius_text.startswith(CAR.wheel_names[wheel])
    assert [each.reason for each in row] == [0] * 4
    for each in row:
        assert abs(each.slip) < 3.0 * each.slip_variance**0.5
        assert abs(each.slip) < 0.01


@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("speed", [8.0, 12.0])
def test_at_low_speed_a_curve_may_hide_which_wheel_it_is_and_the_deviations_of_slip_and_speed_say_so(
    wheel: int, speed: float
) -> None:
    estimator = SlipEstimator(CAR)
    shares = [0.0] * 4
    shares[wheel] = -0.05
    for each in drive(estimator, shares, metres=100.0, speed=speed):
        assert abs(each.slip) < 2.0 * each.slip_variance**0.5
        assert abs(each.vehicle_speed - speed) < 2.0 * each.vehicle_speed_variance**0.5


def test_small_deviations_are_corrected_within_what_is_stated_and_no_wheel_is_named() -> None:
    estimator = SlipEstimator(CAR)
    shares = np.array([0.004, -0.002, -0.003, 0.001])
    drive(estimator, shares.tolist(), metres=600.0)
    left = estimator.car.radius_errors[0] - shares
    assert np.all(np.abs(left - left.mean()) < 2.5 * estimator.car.radius_errors[1])
    assert np.max(np.abs(left - left.mean())) < 0.002
    assert estimator.radius_text == ""


def test_deviations_shrink_while_the_car_rolls() -> None:
    estimator = SlipEstimator(CAR)
    before = apart(estimator)
    drive(estimator, [0.0] * 4, metres=300.0)
    assert apart(estimator) < 0.5 * before


@pytest.mark.parametrize(("speed", "curvature"), [(6.0, 0.1), (10.0, -0.03), (20.0, 0.007)])
def test_a_long_curve_names_no_wheel_and_the_stated_deviation_covers_what_it_moves(
    speed: float, curvature: float
) -> None:
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=10.0 * speed, speed=speed, curvature=curvature)
    moved = estimator.car.radius_errors[0]
    assert np.all(np.abs(moved) < 2.5 * estimator.car.radius_errors[1])
    assert estimator.radius_text == ""


def test_slip_of_braked_wheels_is_not_taken_for_their_radius_beyond_the_deviation() -> None:
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=100.0, force=-1.0, slips=(0.03, 0.03, 0.01, 0.01))
    errors, stddevs = estimator.car.radius_errors
    assert np.all(np.abs(errors) < 2.5 * stddevs)
    assert estimator.radius_text == ""


def test_gentle_traction_of_driven_wheels_is_not_taken_for_their_radius() -> None:
    """0.4 m/s^2 against drag: the rear wheels slip by 0.4 %."""
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=600.0, speed=30.0, force=0.4, slips=(0.0, 0.0, -0.004, -0.004))
    assert estimator.car.radius_errors[0] == pytest.approx([0.0] * 4, abs=0.001)


def test_a_single_corner_has_nothing_to_compare_with() -> None:
    corner = SlipEstimator(replace(CAR, wheels=CAR.wheels[:1], front_load_share=1.0))
    for k in range(1, 400):
        corner.update(k * STEP, [70.0], 0.0)
    assert abs(corner.car.radius_errors[0][0]) < 1e-3


def test_a_speed_sensor_calibrates_the_radii_that_all_wheels_have_alike() -> None:
    estimator = SlipEstimator(CAR)
    rng = np.random.default_rng(3)
    for k in range(1, 8000):
        omega = 20.0 / (0.3 * 1.008) + 0.07 * rng.normal(size=4)
        sensor = [SpeedSample(k * STEP, 20.0 + 0.05 * rng.normal(), 0.0025)] if k % 10 == 0 else []
        row = estimator.update(k * STEP, omega.tolist(), 0.1 * rng.normal(), sensor)
    assert estimator.car.radius_errors[0] == pytest.approx([0.008] * 4, abs=0.002)
    assert all(abs(each.slip) < 0.004 for each in row), "a sample's noise is 0.001"


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
