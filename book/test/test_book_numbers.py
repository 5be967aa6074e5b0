"""A number of the chapter lies inside the middle 90 % of our runs, outside, or there is no interval."""

import pytest

from book.chapter_numbers import NAN, Spread, compared, spread


@pytest.mark.parametrize(
    ("ours", "inside"),
    [(Spread(4.0, 5.0, 6.0), "yes"), (Spread(5.1, 5.5, 6.0), "no"), (Spread(NAN, 5.0, NAN), "")],
)
def test_a_number_lies_inside_outside_or_cannot_be_judged(ours: Spread, inside: str) -> None:
    row = compared("Table 8.2", "error [%]", 5.0, ours)
    assert (row["chapter inside"], row["ours (median)"]) == (inside, ours.median)


def test_runs_without_a_number_are_left_out_of_the_spread() -> None:
    assert spread([*range(101), NAN, float("inf")]) == Spread(5.0, 50.0, 95.0)
    assert all(value != value for value in spread([NAN]))
