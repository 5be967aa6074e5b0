"""Surfaces by distance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.road import Road
from vehicle_models.surfaces import surface


@given(
    st.lists(st.floats(0.1, 1e4), min_size=1, max_size=5, unique=True).map(sorted),
    st.floats(0.0, 2e4),
)
def test_each_distance_lies_on_the_last_surface_that_began_before_it(begins: list[float], distance: float) -> None:
    names = ["dry", "wet", "cobblestone", "snow", "high_grip", "off_road"][: len(begins) + 1]
    distances = [0.0, *begins]
    expected = max(i for i, begin in enumerate(distances) if begin <= distance)
    road = Road(names, distances)
    assert int(road.index(distance)) == expected
    np.testing.assert_array_equal(road.theta(distance), surface(names[expected]))


def test_wheels_at_different_distances_may_stand_on_different_surfaces() -> None:
    road = Road(["dry", "snow"], [0.0, 40.0])
    np.testing.assert_array_equal(road.theta([39.9, 40.0]), [surface("dry"), surface("snow")])


@pytest.mark.parametrize(
    ("names", "distances", "named"),
    [
        ([], [], "surfaces"),
        (["dry", "wet"], [0.0], "surface_distances"),
        (["dry"], [1.0], "surface_distances"),
        (["dry", "wet", "snow"], [0.0, 40.0, 40.0], "surface_distances"),
        (["dry", "wet"], [0.0, float("nan")], "surface_distances"),
        (["dry", "ice"], [0.0, 10.0], "ice"),
    ],
)
def test_a_road_that_cannot_be_laid_is_refused_by_name(names: list[str], distances: list[float], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        Road(names, distances)
