"""The histogram filter: what fits, friction in use, time and neighbours do to the friction of a cell."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("h3")
pytest.importorskip("pyarrow")

from friction_fleet.cells import cell_of, neighbours
from friction_fleet.evidence import Evidence
from friction_fleet.fusion import BETWEEN_TYRES, CHANGE_TIME, SLIPPERY, FrictionMap

HERE = cell_of(48.1, 11.5)
HOUR = 3600.0


def fit(mu: float, stamp: float = 0.0, cell: int = HERE) -> Evidence:
    return Evidence(cell, stamp, "car", mu, 0.02 * mu, True)


def used(mu: float, stamp: float = 0.0, cell: int = HERE, vehicle: str = "") -> Evidence:
    """Friction used by a car; of another car at another time."""
    return Evidence(cell, stamp, vehicle or f"car {stamp}", mu, 0.02, False)


def test_a_fit_is_the_middle_and_its_interval_that_of_measurement_and_tyres() -> None:
    road = FrictionMap()
    road.update(fit(0.8))
    cell = road.at(0.0)[HERE]
    assert cell.median == pytest.approx(0.8, rel=0.03)
    expected = 2.0 * 1.645 * np.hypot(0.02, BETWEEN_TYRES)
    assert np.log(cell.upper / cell.lower) == pytest.approx(expected, rel=0.15)
    assert (cell.fits, cell.passes, cell.vehicles) == (1, 0, 1)


def test_friction_in_use_is_a_lower_bound_and_no_value() -> None:
    road = FrictionMap()
    for stamp in range(20):
        road.update(used(0.5, stamp))
    cell = road.at(20.0)[HERE]
    assert cell.lower > 0.45
    assert cell.median > 0.7
    assert cell.slippery < 0.01


def test_little_friction_in_use_proves_nothing() -> None:
    road = FrictionMap()
    for stamp in range(20):
        road.update(used(0.04, stamp))
    before = FrictionMap()
    before.update(used(0.031))
    assert road.at(20.0)[HERE].median == pytest.approx(before.at(0.0)[HERE].median, rel=0.05)


def test_a_car_that_proves_the_same_again_is_no_evidence() -> None:
    once, often = FrictionMap(), FrictionMap()
    once.update(used(0.8, vehicle="car"))
    for stamp in range(20):
        often.update(used(0.8, stamp, vehicle="car"))
    assert often.at(20.0)[HERE].lower == pytest.approx(once.at(20.0)[HERE].lower, rel=0.01)


def test_ice_is_found_and_forgotten_with_the_time_of_change() -> None:
    road = FrictionMap()
    road.update(fit(0.12))
    soon, late = (road.at(hours * HOUR)[HERE] for hours in (0.1, 20.0 * CHANGE_TIME))
    assert soon.slippery > 0.85
    assert late.slippery < 0.3
    assert late.age == 20.0 * CHANGE_TIME * HOUR


def test_rain_that_other_cells_tell_makes_a_dry_road_doubtful_and_leaves_snow() -> None:
    snow, *others = (cell_of(48.1, 11.5 + 0.002 * k) for k in range(1, 12))
    road = FrictionMap()
    road.update_all([*(fit(1.05, cell=cell) for cell in others[:5]), fit(1.05), fit(0.25, cell=snow)])
    begun = 0.1 * HOUR
    dry = road.at(begun)
    road.update_all(fit(0.75, begun, cell) for cell in others[5:])
    wet = road.at(begun)
    assert dry[HERE].lower > 0.85 > 0.75 > wet[HERE].lower
    assert wet[HERE].slippery < 0.1
    assert wet[snow].slippery > 0.8


def test_wet_roads_of_another_region_say_nothing() -> None:
    road = FrictionMap()
    road.update(fit(1.05))
    before = road.at(HOUR)[HERE]
    road.update_all(fit(0.75, HOUR, cell_of(49.0, 11.5 + 0.002 * k)) for k in range(6))
    assert road.at(HOUR)[HERE] == before


def test_a_single_wrong_fit_does_not_stand_against_friction_in_use() -> None:
    road = FrictionMap()
    road.update(fit(0.3))
    for stamp in range(1, 6):
        road.update(used(0.6, stamp))
    assert road.at(6.0)[HERE].slippery < 0.05


def test_a_neighbour_of_ice_is_suspect_until_it_is_felt() -> None:
    other = neighbours(HERE)[0]
    suspect, felt, alone = FrictionMap(), FrictionMap(), FrictionMap()
    suspect.update_all([fit(0.12), used(0.05, 1.0, other)])
    felt.update_all([fit(0.12), used(0.7, 1.0, other)])
    alone.update(used(0.05, 1.0, other))
    assert suspect.at(1.0)[other].slippery > 2.0 * alone.at(1.0)[other].slippery
    assert felt.at(1.0)[other].slippery < 0.1


@pytest.mark.parametrize(("mu", "slippery"), [(0.1, True), (0.25, True), (0.75, False), (1.05, False)])
def test_intervals_cover_drawn_roads(mu: float, slippery: bool) -> None:
    rng = np.random.default_rng(7)
    covered, right = [], []
    for _ in range(200):
        road = FrictionMap()
        for stamp in range(6):
            tyre = mu * float(np.exp(rng.normal(0.0, BETWEEN_TYRES)))
            if rng.uniform() < 0.3:
                road.update(fit(tyre * float(np.exp(rng.normal(0.0, 0.02))), stamp))
            else:
                road.update(used(min(float(rng.exponential(0.12)) + 0.01, tyre), stamp))
        cell = road.at(6.0)[HERE]
        if cell.fits:
            covered.append(cell.lower <= mu <= cell.upper)
            right.append((cell.slippery > 0.5) == slippery == (mu < SLIPPERY))
    assert np.mean(covered) > 0.85
    assert np.mean(right) > 0.97
