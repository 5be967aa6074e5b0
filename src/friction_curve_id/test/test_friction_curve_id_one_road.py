"""Homogeneous surface check: friction used by each wheel against the common curve."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from numpy.typing import NDArray

from corner_sim.car.driving import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import Recording, record
from corner_sim.car.tyres import TYRES
from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.car.one_road import (
    MOST_CHANGE,
    MOST_MISFIT,
    STILL_CHANGED,
    STILL_MISFIT,
    RoadWatch,
    change_of_friction,
    difference_by_tyres,
    difference_of_sides,
    misfit_at_peak,
)
from friction_curve_id.interface import CurveEstimate
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
LEFT = np.array([[1.0], [-1.0], [1.0], [-1.0]])
TIME = np.arange(0.0, 0.6, 0.005)
FITTED = np.full((4, TIME.size), 0.8)
BY_TYRES = np.array([[0.03] * 4, [0.0] * 4])


def used(since: float = 0.0, sides: Sequence[float] = (1.0, 1.0), noise: float = 0.05) -> Array:
    """Friction that changes by `since` for the newest 0.1 s, and differs by side; the load varies by `noise`."""
    load = 1.0 + np.random.default_rng(1).normal(0.0, noise, FITTED.shape)
    newest = np.where(TIME[-1] - 0.1 < TIME, 1.0 + since, 1.0)
    return np.asarray(FITTED * load * newest * np.array([*sides, *sides])[:, np.newaxis])


def test_a_load_that_varies_is_one_road() -> None:
    assert abs(change_of_friction(used(), FITTED, TIME)) < 0.5 * MOST_CHANGE
    assert abs(difference_of_sides(used(), FITTED, LEFT, TIME)) < difference_by_tyres(FITTED, LEFT, BY_TYRES)


@pytest.mark.parametrize("since", [-0.4, -0.15, 0.15, 1.0])
def test_the_change_is_that_of_the_newest_friction(since: float) -> None:
    assert change_of_friction(used(since), FITTED, TIME) == pytest.approx(np.log(1.0 + since), abs=0.03)


def test_sides_are_compared_left_with_right() -> None:
    assert difference_of_sides(used(sides=(1.2, 0.9)), FITTED, LEFT, TIME) == pytest.approx(np.log(4.0 / 3.0), abs=0.02)


def test_too_little_is_not_compared() -> None:
    assert np.isnan(change_of_friction(used(1.0), FITTED * 0.0, TIME))
    assert np.isnan(change_of_friction(used(1.0), np.where(TIME[-1] - 0.1 < TIME, 0.0, FITTED), TIME))
    assert np.isnan(difference_of_sides(used(), FITTED, np.ones((4, 1)), TIME))


def test_misfit_at_the_peak_is_that_of_the_newest_friction_there() -> None:
    """Of two roads that differ at the peak only, an old one counts neither before nor below it."""
    rising = np.broadcast_to(np.linspace(0.4, 0.8, TIME.size), FITTED.shape)
    less = rising * np.where((rising > 0.72) & (TIME[-1] - 0.15 < TIME), 0.94, 1.3)
    assert misfit_at_peak(less, rising, 0.8, TIME) == pytest.approx(np.log(0.94), abs=1e-6)
    assert np.isnan(misfit_at_peak(less, rising, 1.6, TIME))


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_what_lasts_counts_until_the_end_of_the_braking_and_a_bump_does_not(step: float) -> None:
    """0.06 s are a bump and 0.08 s are not, however often the fits make a step."""
    watch, steps = RoadWatch(), count()

    def update(found: Array) -> str:
        return watch.update(found, FITTED, LEFT, TIME + step * next(steps), np.nan, BY_TYRES)

    assert "changed" in update(used(0.5))
    assert update(used()) == ""
    for _ in range(round(0.06 / step)):
        assert update(used(0.5))
    assert update(used()) == ""
    for _ in range(round(0.08 / step)):
        assert update(used(sides=(1.2, 0.9)))
    assert "sides" in update(used())


def test_a_change_holds_while_nothing_new_is_told_and_while_the_curve_goes_over_to_the_new_road() -> None:
    nothing = np.where(TIME[-1] - 0.1 < TIME, 0.0, FITTED)
    smaller = 0.5 * (MOST_CHANGE + STILL_CHANGED)
    watch = RoadWatch()
    assert watch.update(used(smaller, noise=0.0), FITTED, LEFT, TIME, np.nan, BY_TYRES) == ""
    assert "changed" in watch.update(used(0.5), FITTED, LEFT, TIME, np.nan, BY_TYRES)
    for _ in range(10):
        assert "changed" in watch.update(used(), nothing, LEFT, TIME, np.nan, BY_TYRES)
    for _ in range(10):
        assert "changed" in watch.update(used(smaller, noise=0.0), FITTED, LEFT, TIME, np.nan, BY_TYRES)
    # Neither steps without news nor smaller changes have made it lasting.
    assert watch.update(used(noise=0.0), FITTED, LEFT, TIME, np.nan, BY_TYRES) == ""


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_misfit_at_the_peak_refuses_until_the_friction_there_is_that_of_the_curve_again(sign: float) -> None:
    watch = RoadWatch()
    assert watch.update(used(), FITTED, LEFT, TIME, sign * 0.9 * MOST_MISFIT, BY_TYRES) == ""
    for misfit in (1.1 * MOST_MISFIT, np.nan, 1.1 * STILL_MISFIT):
        for _ in range(10):
            assert "near the peak" in watch.update(used(), FITTED, LEFT, TIME, sign * misfit, BY_TYRES)
    assert watch.update(used(), FITTED, LEFT, TIME, sign * 0.9 * STILL_MISFIT, BY_TYRES) == ""


def stop(split: bool) -> Recording:
    car = random_car(77_000, "dry", "burckhardt")
    dry, wet = (TYRES["burckhardt"][road] for road in ("dry", "wet"))
    parameters = replace(car.parameters, tyres=(dry, wet, dry, wet) if split else (dry,) * 4)
    return record(parameters, SlipCycle(parameters, car.cycling), 77_000, duration=2.4)


@pytest.mark.parametrize("split", [False, True])
def test_a_split_road_is_refused_with_its_reason_and_a_plain_one_is_not(split: bool) -> None:
    run, estimator = stop(split), CarEstimator(load_vehicle("compact_car"))
    reasons, texts = set(), set()
    for k, time in enumerate(run.time.tolist()):
        sample = CarSample(time, run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k]))
        for answer in estimator.update(sample):
            reasons.add(answer.reason)
            if isinstance(answer, CurveEstimate):
                texts.add(answer.text)
                if "different roads" in answer.text:
                    assert not answer.valid and np.isnan(answer.probability_beyond_peak)
    assert (Reason.OK in reasons) is not split
    assert ("the sides of the car are on different roads: waiting for one road" in texts) is split
