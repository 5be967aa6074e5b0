"""Rows of brakings: a fit is contradicted by the friction of its own time, not by that of the road before."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("h3")

from friction_bags.results.places import Places
from friction_bags.results.recorded_run import RecordedRun, Series
from friction_fleet.rows import rows_of_bounds, rows_of_brakings

TIME = np.arange(0.0, 5.0, 0.05)
NOWHERE = Places(np.empty(0, np.int64), np.empty(0), np.empty(0))
Array = NDArray[np.float64]


def run(used: Array, peak: Array) -> RecordedRun:
    """Make a stop from 20 m/s in which friction is used, and a peak is known where it is a number."""
    known = np.isfinite(peak).astype(float)
    stddev = np.full(TIME.size, 0.02)
    of_parts = {f"{part}.{name}": used if name == "mu_used" else stddev for part in PARTS for name in USED}
    grip = {**of_parts, "mu_proven": used - 0.05, "mu_lower": used}
    curve = {"mu_max": peak, "mu_max_stddev": 0.02 + 0.0 * peak, "lambda_max": 0.1 * known, "valid": known}
    curve |= {"lambda_max_stddev": 0.01 * known, "why": 1.0 - known}
    slip = {"vehicle_speed": 20.0 - 4.0 * TIME, "slip": 0.02 + 0.0 * TIME, "valid": np.ones(TIME.size)}
    series = {"grip": grip, "front_left/friction_curve": curve, "front_left/slip": slip}
    return RecordedRun(
        ("front_left",), 0, {name: Series(TIME, each, Counter({"no": 1})) for name, each in series.items()}, TIME
    )


PARTS, USED = ("vehicle", "front", "rear"), ("mu_used", "mu_used_stddev")


@pytest.mark.parametrize(("late", "contradicted"), [(0.11, False), (0.4, True)])
def test_a_fit_is_contradicted_by_friction_of_its_own_time_alone(late: float, contradicted: bool) -> None:
    used, peak = np.where(TIME < 2.0, 0.4, late), np.where(TIME < 3.0, np.nan, 0.12)
    (row,) = rows_of_brakings(run(used, peak), NOWHERE, "key", "car")
    assert row["mu_max"] == pytest.approx(0.12)
    assert row["mu_used"] == pytest.approx(0.4)
    assert row["contradicted"] is contradicted
    assert row["cell"] is None


def test_the_largest_friction_of_a_pass_is_its_bound() -> None:
    (row,) = rows_of_bounds(run(np.where(TIME < 2.0, 0.4, 0.1), np.full(TIME.size, np.nan)), NOWHERE, "key", "car")
    assert (row["mu_used"], row["mu_used_stddev"], row["cell"]) == (0.4, 0.02, None)
    assert row["mu_proven"] == pytest.approx(0.35)
