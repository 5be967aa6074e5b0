"""Memory of a road: proofs and their ages, beliefs, changes of road, curves, priors."""

import numpy as np
import pytest

from friction_grip.road_memory import RoadMemory
from friction_grip.road_prior import GRID, RoadPrior

SECOND = 10**9


def memory(prior: RoadPrior = RoadPrior(), change: float = 300.0, kept: float = 100.0) -> RoadMemory:
    return RoadMemory(prior, change, kept, 0.05)


def drive(road: RoadMemory, distance: float, used: float, stddev: float = 0.01) -> None:
    """Go on by a distance [m] with this friction in use."""
    for _ in range(round(distance)):
        road.drive(1.0)
        road.use(used)
        road.prove(used, stddev, round(road.distance * SECOND))


def test_a_prior_is_a_probability_and_its_quantile_is_the_first_lower_bound() -> None:
    density = RoadPrior().density()
    assert density.sum() == pytest.approx(1.0)
    bounds = memory().bounds()
    assert density[bounds.lower > GRID].sum() == pytest.approx(0.05, abs=0.03)
    assert not bounds.has_proof
    assert np.isnan(bounds.upper)
    with pytest.raises(ValueError, match="0"):
        RoadPrior(0.0, 0.0, 0.0, 0.0)


def test_a_proof_is_below_the_friction_in_use_and_grows_old() -> None:
    road = memory()
    drive(road, 10.0, 0.5)
    drive(road, 50.0, 0.1)
    proof = road.proof()
    assert proof is not None
    assert proof.mu == pytest.approx(0.5 - 2.58 * 0.01)  # 99.5 % on one side
    assert road.distance - proof.distance == pytest.approx(50.0, abs=1.0)
    assert proof.stamp == pytest.approx(10 * SECOND, abs=SECOND)
    drive(road, 60.0, 0.1)
    proof = road.proof()
    assert proof is not None
    assert proof.mu == pytest.approx(0.1 - 2.58 * 0.01)


def test_a_lower_bound_is_above_a_fresh_proof_and_falls_with_the_distance() -> None:
    road = memory()
    drive(road, 20.0, 0.5)
    fresh = road.bounds().lower
    assert fresh > 0.5
    drive(road, 40.0, 0.05)
    later = road.bounds().lower
    drive(road, 200.0, 0.05)
    assert fresh > later > road.bounds().lower


def test_asking_for_little_is_evidence_from_a_driver_who_asks_for_much() -> None:
    brisk, gentle = memory(), memory()
    for road, used in ((brisk, 0.35), (gentle, 0.08)):
        drive(road, 3000.0, used)
        road.prove(0.5, 0.01, 0)
        drive(road, 150.0, 0.05)
    assert brisk.bounds().lower < gentle.bounds().lower


def test_a_curve_bounds_on_both_sides_until_a_proof_contradicts_it() -> None:
    road = memory()
    drive(road, 20.0, 0.15)
    road.take_curve(0.2, 0.01)
    bounds = road.bounds()
    assert bounds.has_curve
    assert 0.15 < bounds.lower < 0.2 < bounds.upper < 0.25
    drive(road, 10.0, 0.15)
    drive(road, 10.0, 0.6)
    bounds = road.bounds()
    assert not bounds.has_curve
    assert bounds.lower > 0.55


def test_on_ice_that_nothing_has_felt_the_prior_alone_speaks() -> None:
    road = memory(RoadPrior(0.0, 0.0, 0.0, 1.0))
    assert road.bounds().lower < 0.05
    summer = memory(RoadPrior(1.0, 0.0, 0.0, 0.0))
    assert summer.bounds().lower > 0.7


def test_no_drive_makes_it_forget_its_probabilities() -> None:
    road = memory()
    generator = np.random.default_rng(1)
    for _ in range(500):
        road.drive(float(generator.uniform(0.0, 30.0)))
        road.use(float(generator.uniform(0.0, 1.0)))
        road.prove(float(generator.uniform(0.0, 1.5)), float(generator.uniform(0.001, 0.1)), 0)
        if generator.uniform() < 0.05:
            road.take_curve(float(generator.uniform(0.05, 1.3)), 0.02)
        bounds = road.bounds()
        assert GRID[0] <= bounds.lower <= GRID[-1]
        assert not bounds.has_curve or bounds.lower <= bounds.upper
