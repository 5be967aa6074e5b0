"""Cost of one update at N = 100, beside padasip's RLS filter (per update) and scipy's curve_fit (batch)."""

import argparse
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from padasip.filters import FilterRLS
from rich.progress import Progress
from scipy.optimize import curve_fit

from benchmarks.identification.chapter_fits import friction_points
from benchmarks.identification.runs import Batch, measured
from benchmarks.identification.studies import on_roads, seeds_of
from benchmarks.protocol import CORNER
from benchmarks.rows import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.interface import CurveEstimator, Sample
from friction_curve_id.methods import METHODS, make_estimator
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1

Array = NDArray[np.float64]

_FROM = 90
"""Updates after this sample count as updates at N = 100."""
_EXPONENTS = np.array([4.0, 36.0, 68.0, 100.0])
"""b of (8.12)."""


def cost(options: argparse.Namespace) -> list[Row]:
    """Time every method on the same samples, one after the other, in this process."""
    truth = on_roads(options.manoeuvre)
    times: dict[str, list[tuple[float, float]]] = {}
    with Progress() as progress:
        bar = progress.add_task("cost", total=len(TABLE_8_1) * options.seeds)
        for surface, name in enumerate(TABLE_8_1):
            for number, seed in seeds_of(surface, options.seeds):
                samples = list(measured(Batch(name, "default", truth, []), number, seed))
                for method in METHODS:
                    times.setdefault(f"{method}, per update", []).extend(
                        _update_times(make_estimator(method, CORNER), samples)
                    )
                for competitor, found in _competitors(samples).items():
                    times.setdefault(competitor, []).extend(found)
                progress.advance(bar)
    rows: list[Row] = []
    for name, pairs in times.items():
        wall, process = np.array(pairs).T
        row: Row = {"what": name, "count": len(pairs)}
        for kind, values in (("wall", wall), ("process", process)):
            row[f"{kind}_ms_median"] = float(np.median(values))
            row[f"{kind}_ms_p99"] = float(np.percentile(values, 99))
        rows.append(row)
    return rows


def _update_times(estimator: CurveEstimator, samples: list[Sample]) -> list[tuple[float, float]]:
    for sample in samples[:_FROM]:
        estimator.update(sample)
    return [_timed(estimator.update, sample) for sample in samples[_FROM:]]


def _competitors(samples: list[Sample]) -> dict[str, list[tuple[float, float]]]:
    """The filter of padasip and curve_fit on the friction samples of the chapter's methods."""
    slips, frictions = friction_points(samples, FrictionSource.DEAD_RECKONED)
    rows = np.column_stack([np.exp(-np.outer(slips, _EXPONENTS)), slips, np.ones_like(slips)])
    rls = FilterRLS(n=rows.shape[1], mu=1.0, eps=1e-3, w="zeros")
    for friction, row in zip(frictions[:-10], rows[:-10], strict=True):
        rls.adapt(friction, row)
    adapted = [_timed(rls.adapt, friction, row) for friction, row in zip(frictions[-10:], rows[-10:], strict=True)]

    def curve(slip: Array, th1: float, th2: float, th3: float) -> Array:
        return burckhardt.friction(np.array([th1, th2, th3]), slip)

    def batch() -> None:
        # A fit that runs out of iterations counts too.
        with suppress(RuntimeError):
            curve_fit(curve, slips, frictions, p0=(0.8, 25.0, 0.4))

    return {"padasip FilterRLS on (8.12), per update": adapted, "scipy curve_fit, batch of 100": [_timed(batch)]}


def _timed(function: Callable[..., object], *arguments: object) -> tuple[float, float]:
    """Wall and CPU time of one call [ms]."""
    wall, process = time.perf_counter_ns(), time.thread_time_ns()
    function(*arguments)
    return (time.perf_counter_ns() - wall) * 1e-6, (time.thread_time_ns() - process) * 1e-6
