"""Tables 8.1 to 8.3 in the chapter's layout, beside its own numbers; the fits of the chapter by name.

The chapter shows one noisy run of each; here its numbers stand beside the medians over the seeds. RML in its usual
form, the recursion of least squares in covariance form on the step (8.10), is

    K = P xi / (1 + xi^T P xi),    theta += K epsilon,    P -= K xi^T P

`friction_curve_id` ships another form, which cannot diverge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

from benchmarks.identification.part import on_roads, seeds_of
from benchmarks.identification.runs import FAILED_ERROR, Batch, measured
from benchmarks.protocol import CORNER, Truth
from benchmarks.runner import Row
from book.chapter_numbers import ITERATIONS, PEAKS, THETA
from friction_curve_id.chapter import maximum_likelihood
from friction_curve_id.chapter.curve_fitting import CurveFit
from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource
from friction_curve_id.chapter.maximum_likelihood import initial_theta
from friction_curve_id.curve.burckhardt_curve import THETA_HIGH, THETA_LOW, BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import Sample
from friction_curve_id.methods import CHAPTER_METHODS
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1

Array = NDArray[np.float64]


class CovarianceRML:
    """RML of section 8.3.1.1 in covariance form; a CurveFit."""

    def __init__(self, covariance: float = 1.0) -> None:
        """Start P at `covariance` times the unit matrix: the chapter names no other."""
        self._covariance = covariance
        self._theta, self._p = np.zeros(3), np.eye(3)

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with theta(0) by (8.11) from the first samples, shapes (n,)."""
        self._theta = initial_theta(slips, frictions)
        self._p = self._covariance * np.eye(3)

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        xi = burckhardt.gradient(self._theta, slip)
        gain = self._p @ xi / (1.0 + float(xi @ self._p @ xi))
        error = friction - float(burckhardt.friction(self._theta, slip))
        self._theta = np.clip(self._theta + gain * error, THETA_LOW, THETA_HIGH)
        self._p = self._p - np.outer(gain, xi @ self._p)

    def curve(self) -> FittedCurve:
        """The curve so far; the chapter gives no deviation."""
        return FittedCurve(BurckhardtCurve(), self._theta, np.full((3, 3), np.nan))


INITIAL_SAMPLES = 20
"""Samples that RML and RLS start from, section 8.3.2."""
FITS: Mapping[str, Callable[[], CurveFit]] = {**CHAPTER_METHODS, "rml_covariance": CovarianceRML}
"""The chapter's methods as shipped, and RML as it is usually written."""


def friction_points(samples: Iterable[Sample], source: FrictionSource) -> tuple[Array, Array]:
    """Slips and frictions of one run, shapes (samples - 1,); fewer where samples were refused."""
    maker = FrictionSamples(CORNER, source)
    points = [point for point in map(maker.update, samples) if isinstance(point, FrictionPoint)]
    slips, frictions = np.array([(point.slip, point.mu) for point in points]).T
    return slips, frictions


def begun(method: str, slips: Array, frictions: Array) -> CurveFit:
    """Return a fit by `method`, begun with the first 20 samples."""
    fit = FITS[method]()
    fit.start(slips[:INITIAL_SAMPLES], frictions[:INITIAL_SAMPLES])
    return fit


def completed(fit: CurveFit, slips: Array, frictions: Array) -> FittedCurve:
    """Return the curve after the samples that follow the first 20."""
    for slip, friction in zip(slips[INITIAL_SAMPLES:], frictions[INITIAL_SAMPLES:], strict=True):
        fit.add(float(slip), float(friction))
    return fit.curve()


_COMPARED_RUNS = 25
"""Runs in which RLS is compared with LS at every sample."""
_EQUAL = 1e-6
"""Difference of lambda_max that counts as none [-]."""
_TABLES = {
    **{"ml": "8.1, 8.2", "rml": "8.1, 8.2", "rml_covariance": "8.1, 8.2"},
    **{"rml_ml": "(8.2)", "ls": "8.3", "rls": "8.3"},
}
"""Tables in which the methods are."""


def chapter_tables(seeds: int) -> list[Row]:
    """Rows of the three tables, one a quantity, with the surfaces as columns and the chapter's number beside each."""
    truth, source = on_roads("B"), FrictionSource.DEAD_RECKONED
    rows = [_truth_row("8.1", f"theta_{k + 1}", truth.theta[:, k]) for k in range(3)]
    lambda_max, mu_max = burckhardt.peak(truth.theta)
    rows += [_truth_row("8.2, 8.3", "lambda_max", lambda_max), _truth_row("8.2, 8.3", "mu_max", mu_max)]
    found = finals(truth, source, seeds, tuple(_TABLES))
    for method, table in _TABLES.items():
        rows += _method_rows(method, table, found[method], lambda_max)
    same = [float(np.nanmax(np.abs(ls[:, 3] - rls[:, 3]))) for ls, rls in zip(found["ls"], found["rls"], strict=True)]
    equal = [
        [_equal_from(*points) for points in surface_points(truth, surface, source, min(seeds, _COMPARED_RUNS))]
        for surface in range(len(TABLE_8_1))
    ]
    rows.append(_row("8.3", "rls", "largest |RLS - LS| of lambda_max", same, None))
    rows.append(_row("8.3", "rls", "sample from which RLS equals LS", [float(max(each)) for each in equal], None))
    return rows


def finals(truth: Truth, source: FrictionSource, seeds: int, methods: Sequence[str]) -> dict[str, list[Array]]:
    """Results of the runs by method and surface, see `_final`; shapes (seeds, 8).

    Args:
        truth: a manoeuvre on each of the surfaces of Table 8.1.
        source: how the friction samples are made.
        seeds: of the noise, for each surface.
        methods: names in `FITS`.
    """
    found: dict[str, list[Array]] = {method: [] for method in methods}
    for surface, name in enumerate(TABLE_8_1):
        runs: dict[str, list[Sequence[float]]] = {method: [] for method in methods}
        for points in track(
            surface_points(truth, surface, source, seeds), description=f"{name}, {source.value}", total=seeds
        ):
            for method in methods:
                runs[method].append(_final(method, *points))
        for method in methods:
            found[method].append(np.array(runs[method]))
    return found


def surface_points(truth: Truth, surface: int, source: FrictionSource, seeds: int) -> Iterator[tuple[Array, Array]]:
    """Yield the friction samples of the runs on one surface."""
    for number, seed in seeds_of(surface, seeds):
        yield friction_points(measured(Batch("", "", truth, []), number, seed), source)


def error_sizes(runs: Sequence[Array], lambda_max: Array) -> list[Array]:
    """Return |error| of lambda_max [%] by surface; a failure is 100.

    Args:
        runs: of one method, from `finals`.
        lambda_max: true, shape (surfaces,).
    """
    errors = [100.0 * np.abs(run[:, 3] / truth - 1.0) for run, truth in zip(runs, lambda_max, strict=True)]
    return [np.where(error <= FAILED_ERROR, error, 100.0) for error in errors]


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
    """Theta (NaN for (8.12)), lambda_max, mu_max, iterations (NaN but for ML), and by how much theta has moved [%]."""
    if method == "ml":
        start = maximum_likelihood.initial_theta(slips[:INITIAL_SAMPLES], frictions[:INITIAL_SAMPLES])
        iterations = float(maximum_likelihood.fit(slips, frictions, start).iterations)
    else:
        iterations = np.nan
    fit = begun(method, slips, frictions)
    at = float(slips[-1]), len(slips), float(np.max(slips))
    first = np.array(fit.curve().estimate(*at).theta)
    estimate = completed(fit, slips, frictions).estimate(*at)
    moved = 100.0 * np.abs(np.array(estimate.theta) / first - 1.0)
    return [*estimate.theta, estimate.lambda_max, estimate.mu_max, iterations, *moved[1:]]


def _method_rows(method: str, table: str, runs: Sequence[Array], lambda_max: Array) -> list[Row]:
    rows: list[Row] = []
    with_theta = method not in ("ls", "rls")
    for k in range(3 if with_theta else 0):
        chapter = [theta[k] for theta in THETA[method]] if method in THETA else None
        rows.append(_row(table, method, f"theta_{k + 1}", [float(np.median(run[:, k])) for run in runs], chapter))
    if method == "ml":
        iterations = [float(np.median(run[:, 5])) for run in runs]
        rows.append(_row(table, method, "iterations", iterations, ITERATIONS))
    if method in ("rml", "rml_covariance"):
        for k in (2, 3):
            moved = [float(np.median(run[:, 4 + k])) for run in runs]
            rows.append(_row(table, method, f"theta_{k} moved from its start [%]", moved, None))
    chapter_peaks = PEAKS.get(method)
    for k, name in enumerate(("lambda_max", "mu_max")):
        chapter = [peak[k] for peak in chapter_peaks] if chapter_peaks else None
        rows.append(_row(table, method, name, [float(np.nanmedian(run[:, 3 + k])) for run in runs], chapter))
    sizes = error_sizes(runs, lambda_max)
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


READINGS = {
    "ours: B, dead reckoning": ("B", FrictionSource.DEAD_RECKONED),
    "C, dead reckoning": ("C", FrictionSource.DEAD_RECKONED),
    "B, wheel equation": ("B", FrictionSource.WHEEL_EQUATION),
    "C, wheel equation": ("C", FrictionSource.WHEEL_EQUATION),
    "B, (8.8) as printed": ("B", FrictionSource.SLIP_EQUATION),
}
"""Manoeuvre (torque built up in 0.25 s: B, in 0.1 s: C) and samples."""
_METHODS = ("ml", "rml", "rml_covariance", "ls")


def readings(seeds: int) -> list[Row]:
    """Rows of |error| of lambda_max [%] at the end by reading, method and surface; a failure counts as 100 %."""
    rows: list[Row] = []
    for reading, (manoeuvre, source) in READINGS.items():
        truth = on_roads(manoeuvre)
        found = finals(truth, source, seeds, _METHODS)
        for method in _METHODS:
            sizes = error_sizes(found[method], burckhardt.peak(truth.theta)[0])
            for surface, name in enumerate(TABLE_8_1):
                low, median, high = np.percentile(sizes[surface], (5.0, 50.0, 95.0))
                rows.append(
                    {
                        "reading": reading,
                        "method": method,
                        "surface": name,
                        "chapter_pct": PEAKS[method][surface][2],
                        "p5_pct": float(low),
                        "median_pct": float(median),
                        "p95_pct": float(high),
                        "failures": int(np.sum(sizes[surface] == 100.0)),
                        "runs": seeds,
                    }
                )
    return rows
