"""Tyre force cross-check outside the loop, against the true forces."""

from math import inf, isnan, nan

import numpy as np
import pytest

from benchmarks.abs.tyre_force_crosscheck import Heard, Opinion

MS = 1_000_000
"""[ns]"""


def heard(*opinions: Opinion) -> Heard:
    """The friction rises by 0.01 in each 5 ms, from 0 to 1."""
    return Heard(list(opinions), [5 * MS * k for k in range(101)], [0.01 * k for k in range(101)])


def test_an_error_is_that_at_the_stamp_of_what_was_said_not_when_it_came() -> None:
    errors, stddevs = heard(Opinion(130 * MS, 100 * MS, 0.25, 0.02), Opinion(140 * MS, 102 * MS, nan, nan)).errors()
    np.testing.assert_allclose(errors, [0.05])
    np.testing.assert_allclose(stddevs, [0.02])


def test_lag_is_from_what_the_tyre_did_to_when_it_was_told() -> None:
    reported = heard(Opinion(430 * MS, 400 * MS, 0.8, 0.02), Opinion(490 * MS, 460 * MS, 0.95, 0.02))
    assert reported.lag(0.9) == pytest.approx(0.04)


def test_what_was_said_before_the_tyre_did_it_does_not_count() -> None:
    assert heard(Opinion(130 * MS, 100 * MS, 0.95, 0.02)).lag(0.9) == inf


def test_a_tyre_that_never_got_there_has_no_lag() -> None:
    assert isnan(heard(Opinion(490 * MS, 460 * MS, 1.2, 0.02)).lag(1.1))
