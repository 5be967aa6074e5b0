"""Braking metrics against closed forms of uniform deceleration."""

from __future__ import annotations

import numpy as np
import pytest

from friction_bags.results.recorded_run import CrossingEvent
from friction_report.braking_metrics import (
    judge_crossings,
    measure_braking,
    release_times,
)
from vehicle_models.constants import GRAVITY

TIME = np.arange(0.0, 12.0, 0.005, dtype=np.float64)


def uniform(mu: float, onset: float = 1.0, initial_speed: float = 30.0) -> np.ndarray:
    """Speed [m/s] of a car that decelerates with mu g from the onset on."""
    return np.maximum(initial_speed - mu * GRAVITY * np.maximum(TIME - onset, 0.0), 0.0)


@pytest.mark.parametrize("mu", [0.3, 0.8])
def test_distance_and_utilisation_of_a_uniform_deceleration_are_the_closed_forms(mu: float) -> None:
    mu_max = 1.0
    result = measure_braking(
        TIME, uniform(mu), np.full_like(TIME, mu), np.full_like(TIME, mu_max), onset=1.0, end_speed=5.0
    )
    energy = result.initial_speed**2 - result.end_speed**2
    assert result.utilisation == pytest.approx(mu / mu_max)
    assert result.distance == pytest.approx(energy / (2.0 * GRAVITY * mu), rel=1e-6)
    assert result.ideal_distance == pytest.approx(energy / (2.0 * GRAVITY * mu_max), rel=1e-3)
    assert result.initial_speed == 30.0
    assert 5.0 < result.end_speed < 5.0 + mu * GRAVITY * 0.0051


def test_distance_before_the_onset_and_below_the_end_speed_does_not_count() -> None:
    mu = np.full_like(TIME, 0.8)
    late = measure_braking(TIME, uniform(0.8, onset=3.0), mu, mu, onset=3.0)
    early = measure_braking(TIME, uniform(0.8, onset=1.0), mu, mu, onset=1.0)
    assert late.distance == pytest.approx(early.distance, rel=1e-9)
    assert late.ideal_distance == pytest.approx(late.distance, rel=1e-3)


def test_ideal_follows_the_road_that_is_reached() -> None:
    """Dry for 20 m, then snow: the ideal car loses 2 g 1.0 20 of its speed squared on the first part."""
    mu = 0.1
    speed = np.maximum(30.0 - mu * GRAVITY * TIME, 0.0)
    covered = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(TIME))])
    mu_max = np.where(covered < 20.0, 1.0, 0.2)
    result = measure_braking(TIME, speed, np.full_like(TIME, mu), mu_max, onset=0.0, end_speed=20.0)
    lost = 900.0 - result.end_speed**2 - 2.0 * GRAVITY * 1.0 * 20.0
    assert result.ideal_distance == pytest.approx(20.0 + lost / (2.0 * GRAVITY * 0.2), rel=5e-3)


def test_build_up_is_left_out_of_the_second_utilisation() -> None:
    mu = np.where(TIME < 1.4, 0.0, 0.8)
    result = measure_braking(TIME, np.full_like(TIME, 20.0), mu, np.ones_like(TIME), onset=1.0)
    assert result.utilisation_built_up == pytest.approx(0.8)
    assert result.utilisation < 0.8


def test_a_release_lasts_to_the_first_sample_after_it_or_to_the_last_one() -> None:
    released = np.array([False, True, True, False, True, False, False, True])
    time = np.array([0.0, 0.1, 0.2, 0.4, 0.5, 0.8, 0.9, 1.0])
    assert release_times(time, released) == pytest.approx([0.3, 0.3, 0.0])
    assert release_times(time, np.zeros(8, dtype=np.bool_)).size == 0
    assert release_times(time, np.ones(8, dtype=np.bool_)) == pytest.approx([1.0])


def test_no_braking_is_an_error_and_not_a_number() -> None:
    with pytest.raises(ValueError, match="no braking above"):
        measure_braking(TIME, np.zeros_like(TIME), TIME, TIME + 1.0, onset=1.0)


def test_crossing_is_judged_by_the_nearest_true_one_of_its_sign_and_none_is_claimed_twice() -> None:
    truth = [CrossingEvent(1.0, -1, 0.17), CrossingEvent(1.5, 1, 0.17), CrossingEvent(2.0, -1, 0.03)]
    estimates = [CrossingEvent(0.85, -1, 0.2), CrossingEvent(1.1, -1, 0.2), CrossingEvent(1.98, -1, 0.03)]
    lambda_max = np.where(TIME < 1.9, 0.17, 0.03)
    farther, late, foreseen = judge_crossings(estimates, truth, TIME, lambda_max)
    assert late.delay == pytest.approx(0.1)
    assert late.relative_error == pytest.approx(0.2 / 0.17 - 1.0)
    assert np.isnan(farther.delay)
    assert foreseen.delay == pytest.approx(-0.02)
    assert foreseen.lambda_max == 0.03


def test_crossing_of_the_other_sign_or_far_away_is_not_the_true_one() -> None:
    truth = [CrossingEvent(1.0, 1, 0.17), CrossingEvent(1.25, -1, 0.17)]
    judged = judge_crossings([CrossingEvent(1.0, -1, 0.1)], truth, TIME, np.full_like(TIME, 0.17))
    assert np.isnan(judged[0].delay)
