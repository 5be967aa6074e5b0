"""A picture with fewer points keeps every extreme, nearly where it was."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from friction_report.thinning import bucket_edges, decimate, last_of_buckets

TIME = np.arange(0.0, 100.0, 0.005)
EDGES = bucket_edges(0.0, 100.0, [(40.0, 42.0)], 100, 300)


def test_a_spike_of_one_sample_stays_in_every_column_nearly_where_it_was() -> None:
    columns = np.zeros((TIME.size, 2))
    columns[7001, 0], columns[12345, 1] = 5.0, -3.0
    time, found = decimate(TIME, columns, EDGES)
    assert time.size < 1000
    for column, value, at in ((0, 5.0, TIME[7001]), (1, -3.0, TIME[12345])):
        rows = np.flatnonzero(found[:, column])
        assert found[rows, column] == pytest.approx([value])
        assert time[rows] == pytest.approx(at, abs=1.0)


def test_extremes_of_every_bucket_are_those_of_all_its_samples_in_their_order() -> None:
    values = np.random.default_rng(1).normal(size=(TIME.size, 1))
    time, found = decimate(TIME, values, EDGES)
    for begin, end in pairwise(EDGES):
        all_of = values[slice(*np.searchsorted(TIME, (begin, end))), 0]
        kept = found[slice(*np.searchsorted(time, (begin, end))), 0]
        assert (kept.min(), kept.max()) == (all_of.min(), all_of.max())
        assert kept.argmin() <= kept.argmax() or all_of.argmin() > all_of.argmax()


def test_brakings_are_shown_more_finely_than_the_rest() -> None:
    time, _ = decimate(TIME, TIME[:, None], EDGES)
    assert np.count_nonzero((time > 40.0) & (time < 42.0)) > 300
    assert np.count_nonzero((time > 60.0) & (time < 62.0)) < 10


def test_times_stay_in_order_and_no_bucket_gives_more_than_two_rows() -> None:
    uneven = np.sort(np.random.default_rng(2).uniform(0.0, 100.0, 5000))
    time, found = decimate(uneven, uneven[:, None], EDGES)
    assert np.all(np.diff(time) > 0.0)
    assert found.shape == (time.size, 1)
    assert time.size <= 2 * (EDGES.size + 1)


def test_unknown_values_hide_no_extreme_and_stay_where_nothing_is_known() -> None:
    values = np.full((TIME.size, 1), np.nan)
    values[::2] = 1.0
    values[TIME > 50.0] = np.nan
    time, found = decimate(TIME, values, EDGES)
    assert np.all(found[time < 39.0] == 1.0)
    assert np.all(np.isnan(found[time > 51.0]))


@pytest.mark.parametrize("number", [0, 1, 2])
def test_few_rows_stay_as_they_are(number: int) -> None:
    time = np.array([3.0, 3.001])[:number]
    kept, found = decimate(time, np.array([[1.0], [np.nan]])[:number], EDGES)
    assert np.array_equal(kept, time)
    assert np.array_equal(found, np.array([[1.0], [np.nan]])[:number], equal_nan=True)
    assert last_of_buckets(time, EDGES).tolist() == ([number - 1] if number else [])


def test_last_of_each_bucket_is_kept_of_what_belongs_together() -> None:
    assert last_of_buckets(np.array([0.1, 0.2, 1.1, 5.5]), np.array([0.0, 1.0, 2.0])).tolist() == [1, 2, 3]


def test_edges_of_a_drive_without_length_or_with_a_braking_at_its_end_are_in_order() -> None:
    assert bucket_edges(0.0, 0.0, [], 10, 10).tolist() == [0.0]
    assert np.all(np.diff(bucket_edges(0.0, 5.0, [(4.0, 5.0), (4.8, 5.0)], 10, 10)) > 0.0)
