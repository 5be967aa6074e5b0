"""Grip against the truth of a plant that shares no code with it, on one short drive."""

import pytest

from benchmarks.runner import Row, rows_of


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    """Rows by their quantity."""
    return {row["quantity"]: row for row in rows_of("benchmarks", "grip", "--cars", "1", "--minutes", "0.2")}


@pytest.mark.parametrize("part", ["car", "front", "rear", "wheels"])
@pytest.mark.parametrize("known", ["", ", bias known to 0.05 m/s^2"])
def test_friction_used_is_within_its_interval(rows: dict[str, Row], part: str, known: str) -> None:
    row = rows[f"friction used, {part}{known}: 95 % intervals cover [%]"]
    assert row["passed"], row


def test_a_proof_is_below_the_road_that_it_is_of(rows: dict[str, Row]) -> None:
    assert rows["mu_proven above the road that it is of [% of time]"]["value"] == 0.0


def test_what_a_driver_comes_to_know_is_told_by_road(rows: dict[str, Row]) -> None:
    told = [row for quantity, row in rows.items() if quantity.startswith("mu_proven, median, usual driver")]
    assert told
    assert all(0.0 < row["value"] < row["of mu_lower"] < 1.2 for row in told)
