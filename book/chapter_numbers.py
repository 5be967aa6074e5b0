"""The numbers of the chapter, and how they lie among ours.

Most numbers of the chapter are of a single run. Ours are the median of many runs and their middle 90 %; a number of the
chapter within that interval is one that these runs could have given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.runner import Row

NAN = float("nan")


class Spread(NamedTuple):
    """Middle 90 % of our runs and their median; a limit that is NaN is not known."""

    low: float
    median: float
    high: float


SLIP_AT_DETECTION = {
    ("high_grip", "(8.4)"): 0.0854,
    ("off_road", "(8.4)"): 0.1357,
    ("high_grip", "(8.5)"): 0.0648,
    ("off_road", "(8.5)"): 0.1283,
}
"""Section 8.2.3, mean over its test drives, by road and equation [-]."""
THETA = {
    "ml": [(1.29, 22.69, 0.57), (0.86, 31.94, 0.36), (1.48, 5.79, 0.85), (0.18, 90.95, 0.04)],
    "rml": [(1.24, 27.34, 0.38), (0.86, 35.36, 0.37), (1.12, 9.73, 0.29), (0.22, 60.07, 0.37)],
}
"""Table 8.1, on dry, wet, cobblestone, snow."""
ITERATIONS = (4, 4, 5, 4)
"""Table 8.1, of ML."""
PEAKS = {
    "ml": [(0.1737, 1.1700, 2.17), (0.1350, 0.8035, 3.28), (0.3989, 0.9998, 0.15), (0.0656, 0.1848, 8.42)],
    "rml": [(0.1641, 1.1679, 3.47), (0.1242, 0.8048, 4.97), (0.3723, 0.9906, 6.8), (0.0594, 0.1929, 1.81)],
    "ls": [(0.1786, 1.1696, 5.05), (0.1370, 0.8024, 4.84), (0.3966, 1.0019, 0.73), (0.0658, 0.1849, 8.76)],
}
"""Tables 8.2 and 8.3: lambda_max, mu_max, |error| of lambda_max [%]; its RLS equals its LS."""
for _same, _as in (("rls", "ls"), ("rml_covariance", "rml")):
    PEAKS[_same] = PEAKS[_as]
THETA["rml_covariance"] = THETA["rml"]
SAMPLES_WITHIN = {("rml", 10): 30.0, ("rls", 10): 40.0, ("rls", 5): 70.0}
"""Figures 8.6 and 8.8: sample from which lambda_max on cobblestone stays within a limit [%]."""
ERRORS_ON_ROADS = {
    ("high_grip", "rls", "measured"): (1.9, -4.5),
    ("high_grip", "rml_ml", "measured"): (4.7, -5.8),
    ("off_road", "rls", "measured"): (-1.69, -5.69),
    ("off_road", "rml_ml", "measured"): (-19.46, -18.23),
    ("high_grip", "rls", "estimated"): (0.2, -4.7),
    ("off_road", "rls", "estimated"): (-1.38, -5.3),
}
"""Tables 8.4 and 8.5 by road, method and speed: error of lambda_max [%] at the ABS activation and at the end."""
LENGTH_OF_PATCH = 25.0
"""Figures 8.22 and 8.23: length of the contact patch at constant speed, without the speed trend [deg]."""


def compared(place: str, quantity: str, chapter: float, ours: Spread) -> Row:
    """Return a row of the table: a number of the chapter beside ours."""
    inside = None if np.isnan([ours.low, ours.high]).any() else bool(ours.low <= chapter <= ours.high)
    return {
        "place": place,
        "quantity": quantity,
        "chapter": chapter,
        "ours (median)": ours.median,
        "5 %": ours.low,
        "95 %": ours.high,
        "chapter inside": {None: "", True: "yes", False: "no"}[inside],
    }


def spread(values: Sequence[float]) -> Spread:
    """Return the spread of the runs that gave a number."""
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    return (
        Spread(*(float(each) for each in np.percentile(known, (5.0, 50.0, 95.0)))) if known.size else Spread(*[NAN] * 3)
    )


def spread_of(row: Mapping[str, float], unit: str) -> Spread:
    """Return the spread that a row of a table holds."""
    return Spread(row[f"p5_{unit}"], row[f"median_{unit}"], row[f"p95_{unit}"])
