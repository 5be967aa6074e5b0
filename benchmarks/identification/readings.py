"""Readings of section 8.3.2: what the chapter leaves open, and which of its numbers each way to read it gives.

Its friction samples need a slip rate and a speed, and it does not say how they were smoothed; nor does it name the
manoeuvre. The chapter's numbers come from single runs, so that each is set against the middle 90 % of ours.
"""

import argparse

import numpy as np

from benchmarks.identification.chapter_tables import CHAPTER_PEAKS, error_sizes, finals
from benchmarks.identification.studies import on_roads
from benchmarks.rows import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1

READINGS = {
    "ours: B, dead reckoning": ("B", FrictionSource.DEAD_RECKONED),
    "C, dead reckoning": ("C", FrictionSource.DEAD_RECKONED),
    "B, wheel equation": ("B", FrictionSource.WHEEL_EQUATION),
    "C, wheel equation": ("C", FrictionSource.WHEEL_EQUATION),
    "B, (8.8) as printed": ("B", FrictionSource.SLIP_EQUATION),
}
"""Manoeuvre (torque built up in 0.25 s: B, in 0.1 s: C) and samples."""
_METHODS = ("ml", "rml", "rml_covariance", "ls")


def readings(options: argparse.Namespace) -> list[Row]:
    """Rows of |error| of lambda_max [%] at the end by reading, method and surface; a failure counts as 100 %."""
    rows: list[Row] = []
    for reading, (manoeuvre, source) in READINGS.items():
        truth = on_roads(manoeuvre)
        found = finals(truth, source, options.seeds, _METHODS)
        for method in _METHODS:
            sizes = error_sizes(found[method], burckhardt.peak(truth.theta)[0])
            for surface, name in enumerate(TABLE_8_1):
                low, median, high = np.percentile(sizes[surface], (5.0, 50.0, 95.0))
                rows.append(
                    {
                        "reading": reading,
                        "method": method,
                        "surface": name,
                        "chapter_pct": CHAPTER_PEAKS[method][surface][2],
                        "p5_pct": float(low),
                        "median_pct": float(median),
                        "p95_pct": float(high),
                        "failures": int(np.sum(sizes[surface] == 100.0)),
                        "runs": options.seeds,
                    }
                )
    return rows
