"""Radii relative to each other, learned while the car rolls without force."""

from dataclasses import replace

import numpy as np
import pytest

from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimate import WheelEstimate
from wheel_slip.estimator import SlipEstimator

STEP = 5_000_000
CAR = load_vehicle("compact_car")
SIDES = np.array([-1.0, 1.0, -1.0, 1.0])


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
    true = speed * (1.0 + SIDES * curvature * CAR.track / 2.0) * (1.0 - np.array(slips)) / radii
    row: list[WheelEstimate] = []
    for k in range(1, round(metres / speed / 0.005)):
        omega = true + 0.07 * rng.normal(size=4)
        row = estimator.update(k * STEP, omega.tolist(), force + 0.1 * rng.normal())
    return row


@pytest.mark.parametrize("speed", [22.0, 35.0])
@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("error", [-0.05, 0.05])
def test_one_wheel_far_off_its_file_is_found_within_100_metres_named_and_corrected(
    wheel: int, speed: float, error: float
) -> None:
    estimator = SlipEstimator(CAR)
    shares = [0.0] * 4
    shares[wheel] = error
    row = drive(estimator, shares, metres=100.0, speed=speed)
    assert np.array(estimator.radii) / 0.3 - 1.0 == pytest.approx(shares, abs=0.006)
    assert estimator.radius_text.startswith(CAR.wheel_names[wheel])
    assert [each.reason for each in row] == [0] * 4
    for each in row:
        assert abs(each.slip) < 3.0 * each.slip_variance**0.5
        assert abs(each.slip) < 0.006


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
    left = np.array(estimator.radii) / 0.3 - 1.0 - shares
    assert np.all(np.abs(left - left.mean()) < 2.5 * np.sqrt(estimator.radius_variances))
    assert np.max(np.abs(left - left.mean())) < 0.002
    assert estimator.radius_text == ""


def test_deviations_shrink_while_the_car_rolls() -> None:
    estimator = SlipEstimator(CAR)
    before = estimator.radius_variances
    drive(estimator, [0.0] * 4, metres=300.0)
    assert all(now < 0.5 * then for now, then in zip(estimator.radius_variances, before, strict=True))


@pytest.mark.parametrize(("speed", "curvature"), [(6.0, 0.1), (10.0, -0.03), (20.0, 0.007)])
def test_a_long_curve_names_no_wheel_and_the_stated_deviation_covers_what_it_moves(
    speed: float, curvature: float
) -> None:
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=10.0 * speed, speed=speed, curvature=curvature)
    moved = np.array(estimator.radii) / 0.3 - 1.0
    assert np.all(np.abs(moved) < 2.5 * np.sqrt(estimator.radius_variances))
    assert estimator.radius_text == ""


def test_braked_wheels_teach_nothing() -> None:
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=100.0, force=-1.0, slips=(0.03, 0.03, 0.01, 0.01))
    assert estimator.radii == CAR.radii


def test_gentle_traction_of_driven_wheels_is_not_taken_for_their_radius() -> None:
    """0.4 m/s^2 against drag: the rear wheels slip by 0.4 %."""
    estimator = SlipEstimator(CAR)
    drive(estimator, [0.0] * 4, metres=600.0, speed=30.0, force=0.4, slips=(0.0, 0.0, -0.004, -0.004))
    assert np.array(estimator.radii) / 0.3 - 1.0 == pytest.approx([0.0] * 4, abs=0.001)


def test_a_single_corner_has_nothing_to_compare_with() -> None:
    corner = SlipEstimator(replace(CAR, wheels=CAR.wheels[:1], front_load_share=1.0))
    for k in range(1, 400):
        corner.update(k * STEP, [70.0], 0.0)
    assert corner.radii == (0.3,)
    assert corner.radius_variances == [0.0]
