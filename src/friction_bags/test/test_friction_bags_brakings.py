"""Brakings are found by the speed alone, whatever gaps and stamps it has."""

from __future__ import annotations

import numpy as np
import pytest

from friction_bags.results.brakings import all_brakings, hardest_braking

TIME = np.arange(0.0, 12.0, 0.005)


def test_hardest_braking_is_found_among_gentle_ones_and_through_gaps() -> None:
    speed = np.interp(TIME, [0.0, 2.0, 3.0, 5.0, 6.0, 8.0, 12.0], [20.0, 20.0, 18.0, 18.0, 8.0, 8.0, 0.0])
    speed[(TIME > 5.2) & (TIME < 5.4)] = np.nan
    begin, end = hardest_braking(TIME, speed) or (np.nan, np.nan)
    assert begin == pytest.approx(5.0, abs=0.2)
    assert end == pytest.approx(6.0, abs=0.2)


def test_gentle_drive_has_no_hardest_braking() -> None:
    assert hardest_braking(TIME, 20.0 - TIME) is None
    assert hardest_braking(TIME, np.full_like(TIME, np.nan)) is None


def test_every_braking_is_found_and_coasting_is_none() -> None:
    """Braking at 2, coasting at 0.5, braking at 6 m/s^2."""
    speed = np.interp(TIME, [0.0, 1.0, 3.0, 7.0, 8.0, 12.0], [20.0, 20.0, 16.0, 14.0, 8.0, 8.0])
    found = all_brakings(TIME, speed)
    assert len(found) == 2
    for span, true in zip(found, [(1.0, 3.0), (7.0, 8.0)], strict=True):
        assert span == pytest.approx(true, abs=0.2)


def test_a_short_release_does_not_end_a_braking_and_a_long_one_does() -> None:
    for pause, number in ((0.2, 1), (1.0, 2)):
        speed = np.interp(TIME, [2.0, 3.0, 3.0 + pause, 4.0 + pause], [20.0, 14.0, 14.0, 8.0])
        assert len(all_brakings(TIME, speed)) == number


def test_a_bump_is_no_braking() -> None:
    speed = 20.0 - 0.5 * np.exp(-(((TIME - 5.0) / 0.1) ** 2))
    assert all_brakings(TIME, speed) == []


@pytest.mark.parametrize("time", [[], [1.0], [0.0, 0.001, 0.002], [0.0, 1.7e9, 1.7e9 + 1.0]])
def test_few_and_far_samples_are_no_braking_and_no_burden(time: list[float]) -> None:
    assert all_brakings(np.array(time), np.full(len(time), 3.0)) == []


def test_a_short_braking_counts_where_a_curve_was_valid_in_it() -> None:
    """On snow, 0.4 s of braking lose 0.7 m/s."""
    speed = np.interp(TIME, [5.0, 5.4], [20.0, 19.3])
    assert all_brakings(TIME, speed) == []
    assert len(all_brakings(TIME, speed, np.array([5.3]))) == 1
    assert all_brakings(TIME, speed, np.array([8.0])) == []
