"""Tables 8.1, 8.2 and 8.3 in the chapter's layout, beside the chapter's own numbers.

The chapter shows one noisy run of each; here its numbers stand beside the medians over the seeds. `source` is
that of the friction samples (default: dead_reckoned).
"""

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from friction_curve_id.chapter import maximum_likelihood
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_evaluation.identification.chapter_fits import INITIAL_SAMPLES, begun, completed, friction_points
from friction_evaluation.identification.runs import Batch, measured
from friction_evaluation.identification.studies import roads, seeds_of
from friction_evaluation.manoeuvres import braking
from friction_evaluation.rows import Row
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1

Array = NDArray[np.float64]

_COMPARED_RUNS = 25
"""Runs in which RLS is compared with LS at every sample."""
_EQUAL = 1e-6
"""Difference of lambda_max that counts as none [-]."""
_CHAPTER_8_1 = {
    "ml": [(1.29, 22.69, 0.57), (0.86, 31.94, 0.36), (1.48, 5.79, 0.85), (0.18, 90.95, 0.04)],
    "rml": [(1.24, 27.34, 0.38), (0.86, 35.36, 0.37), (1.12, 9.73, 0.29), (0.22, 60.07, 0.37)],
}
"""theta of Table 8.1, in the order of the surfaces."""
_CHAPTER_ITERATIONS = (4, 4, 5, 4)
_CHAPTER_8_2_8_3 = {
    "ml": [(0.1737, 1.1700, 2.17), (0.1350, 0.8035, 3.28), (0.3989, 0.9998, 0.15), (0.0656, 0.1848, 8.42)],
    "rml": [(0.1641, 1.1679, 3.47), (0.1242, 0.8048, 4.97), (0.3723, 0.9906, 6.8), (0.0594, 0.1929, 1.81)],
    "ls": [(0.1786, 1.1696, 5.05), (0.1370, 0.8024, 4.84), (0.3966, 1.0019, 0.73), (0.0658, 0.1849, 8.76)],
}
"""lambda_max, mu_max and the error of lambda_max [%]; the chapter's RLS equals its LS."""
_CHAPTER_8_2_8_3["rls"] = _CHAPTER_8_2_8_3["ls"]


def chapter_tables(options: argparse.Namespace) -> list[Row]:
    """Rows of the three tables, one a quantity, with the surfaces as columns and the chapter's number beside each."""
    truth = braking(options.manoeuvre, roads())
    source = FrictionSource(options.source)
    tables = {"ml": "8.1, 8.2", "rml": "8.1, 8.2", "rml_ml": "(8.2)", "ls": "8.3", "rls": "8.3"}
    rows = [_truth_row("8.1", f"theta_{k + 1}", truth.theta[:, k]) for k in range(3)]
    lambda_max, mu_max = burckhardt.peak(truth.theta)
    rows += [_truth_row("8.2, 8.3", "lambda_max", lambda_max), _truth_row("8.2, 8.3", "mu_max", mu_max)]
    found: dict[str, list[Array]] = {method: [] for method in tables}
    equal: list[list[int]] = [[] for _ in TABLE_8_1]
    for surface, name in enumerate(TABLE_8_1):
        batch, runs = Batch(name, "", truth, []), seeds_of(surface, options.seeds)
        finals: dict[str, list[Sequence[float]]] = {method: [] for method in tables}
        for number, seed in track(runs, description=f"Tables 8.1 to 8.3, {name}"):
            points = friction_points(measured(batch, number, seed), source)
            for method in tables:
                finals[method].append(_final(method, *points))
            if len(equal[surface]) < _COMPARED_RUNS:
                equal[surface].append(_equal_from(*points))
        for method in tables:
            found[method].append(np.array(finals[method]))
    for method, table in tables.items():
        rows += _method_rows(method, table, found[method], lambda_max)
    same = [float(np.nanmax(np.abs(ls[:, 3] - rls[:, 3]))) for ls, rls in zip(found["ls"], found["rls"], strict=True)]
    rows.append(_row("8.3", "rls", "largest |RLS - LS| of lambda_max", same, None))
    rows.append(_row("8.3", "rls", "sample from which RLS equals LS", [float(max(each)) for each in equal], None))
    return rows


def _equal_from(slips: Array, frictions: Array) -> int:
    """Sample (of the sensors) from which on lambda_max of RLS and of LS agree."""
    fits = begun("ls", slips, frictions), begun("rls", slips, frictions)
    differs = INITIAL_SAMPLES
    for k in range(INITIAL_SAMPLES, len(slips)):
        for fit in fits:
            fit.add(float(slips[k]), float(frictions[k]))
        ls, rls = (curve.model.peak(curve.parameters) for curve in (fit.curve() for fit in fits))
        if abs(ls - rls) > _EQUAL or np.isnan(ls) != np.isnan(rls):
            differs = k + 1
    return differs + 1


def _final(method: str, slips: Array, frictions: Array) -> Sequence[float]:
    """Theta (NaN for (8.12)), lambda_max, mu_max and the iterations (NaN but for ML) after all samples."""
    if method == "ml":
        start = maximum_likelihood.initial_theta(slips[:INITIAL_SAMPLES], frictions[:INITIAL_SAMPLES])
        iterations = float(maximum_likelihood.fit(slips, frictions, start).iterations)
    else:
        iterations = np.nan
    fit = begun(method, slips, frictions)
    estimate = completed(fit, slips, frictions).estimate(float(slips[-1]), len(slips), float(np.max(slips)))
    return [*estimate.theta, estimate.lambda_max, estimate.mu_max, iterations]


def _method_rows(method: str, table: str, runs: Sequence[Array], lambda_max: Array) -> list[Row]:
    rows: list[Row] = []
    with_theta = method in ("ml", "rml", "rml_ml")
    for k in range(3 if with_theta else 0):
        chapter = [theta[k] for theta in _CHAPTER_8_1[method]] if method in _CHAPTER_8_1 else None
        rows.append(_row(table, method, f"theta_{k + 1}", [float(np.median(run[:, k])) for run in runs], chapter))
    if method == "ml":
        iterations = [float(np.median(run[:, 5])) for run in runs]
        rows.append(_row(table, method, "iterations", iterations, _CHAPTER_ITERATIONS))
    chapter_peaks = _CHAPTER_8_2_8_3.get(method)
    for k, name in enumerate(("lambda_max", "mu_max")):
        chapter = [peak[k] for peak in chapter_peaks] if chapter_peaks else None
        rows.append(_row(table, method, name, [float(np.nanmedian(run[:, 3 + k])) for run in runs], chapter))
    errors = [100.0 * np.abs(run[:, 3] / truth - 1.0) for run, truth in zip(runs, lambda_max, strict=True)]
    sizes = [np.where(error <= 50.0, error, 100.0) for error in errors]
    chapter = [peak[2] for peak in chapter_peaks] if chapter_peaks else None
    rows.append(_row(table, method, "median |error| of lambda_max [%]", [float(np.median(s)) for s in sizes], chapter))
    rows.append(_row(table, method, "failures", [int(np.sum(size == 100.0)) for size in sizes], None))
    return rows


def _truth_row(table: str, quantity: str, values: Array) -> Row:
    return _row(table, "true values", quantity, values.tolist(), None)


def _row(table: str, method: str, quantity: str, values: Sequence[float], chapter: Sequence[float] | None) -> Row:
    row: Row = {"table": table, "method": method, "quantity": quantity}
    for surface, name in enumerate(TABLE_8_1):
        row[name] = values[surface]
        row[f"{name}_chapter"] = chapter[surface] if chapter is not None else float("nan")
    return row
