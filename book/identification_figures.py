"""Figures 8.5 to 8.8 for every method and surface: the fit, and lambda_max against samples.

One run each. Left (Figures 8.5 and 8.7) the friction samples, the true curve, the first and the last fitted
curve and both peaks; right
(Figures 8.6 and 8.8) lambda_max against samples with the 5 % band and the initialisation period.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.identification.fits import begun, completed, friction_points
from benchmarks.identification.runs import Batch, measured
from benchmarks.identification.studies import on_roads, seeds_of
from benchmarks.protocol import CORNER, SAMPLES
from benchmarks.rows import Row
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import CurveEstimate, Refusal
from friction_curve_id.methods import CHAPTER_METHODS, exact_wheel_estimator
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1

Array = NDArray[np.float64]
_MANOEUVRE = "B"

Curve = Callable[[Array], Array]


def figures(directory: Path, methods: Sequence[str]) -> list[Row]:
    """Draw a file per method and surface into the directory; return their names."""
    directory.mkdir(parents=True, exist_ok=True)
    truth = on_roads(_MANOEUVRE)
    source = FrictionSource.DEAD_RECKONED
    rows: list[Row] = []
    with Progress() as progress:
        bar = progress.add_task("figures", total=len(TABLE_8_1) * len(methods))
        for surface, name in enumerate(TABLE_8_1):
            number, seed = seeds_of(surface, 1)[0]
            samples = list(measured(Batch(name, "", truth, []), number, seed))
            points = friction_points(samples, source)
            for method in methods:
                estimator = exact_wheel_estimator(method, CORNER, source=source)
                answers = [estimator.update(sample) for sample in samples]
                figure = Figure(figsize=(11.0, 4.0), layout="constrained")
                left, right = figure.subplots(1, 2)
                last = answers[-1]
                peak = last.lambda_max if isinstance(last, CurveEstimate) else np.nan
                _draw_fit(left, points, _curves(method, points, answers), peak, truth.theta[surface])
                _draw_history(right, answers, float(burckhardt.peak(truth.theta[surface])[0]))
                figure.suptitle(f"{method} on {name}, manoeuvre {_MANOEUVRE}")
                path = directory / f"identification_{_MANOEUVRE}_{name}_{method}.png"
                figure.savefig(path, dpi=120)
                error = 100.0 * (peak / float(burckhardt.peak(truth.theta[surface])[0]) - 1.0)
                rows.append({"surface": name, "method": method, "error_pct": error, "figure": str(path)})
                progress.advance(bar)
    return rows


def _curves(method: str, points: tuple[Array, Array], answers: list[CurveEstimate | Refusal]) -> tuple[Curve, Curve]:
    """Return the first and the last curve that a method fitted."""
    if method not in CHAPTER_METHODS:
        thetas = [answer.theta for answer in answers if isinstance(answer, CurveEstimate)]
        return partial(burckhardt.friction, thetas[0]), partial(burckhardt.friction, thetas[-1])
    fit = begun(method, *points)
    first = fit.curve()
    last = completed(fit, *points)

    def drawn(curve: FittedCurve) -> Curve:
        return lambda grid: np.array([curve.model.friction(curve.parameters, float(slip)) for slip in grid])

    return drawn(first), drawn(last)


def _draw_fit(axes: Axes, points: tuple[Array, Array], curves: tuple[Curve, Curve], peak: float, theta: Array) -> None:
    slips, frictions = points
    axes.plot(slips, frictions, ".", color="0.6", label="friction samples")
    grid = np.linspace(0.0, 1.1 * float(slips.max()), 200, dtype=np.float64)
    axes.plot(grid, burckhardt.friction(theta, grid), "k--", label="true")
    axes.axvline(float(burckhardt.peak(theta)[0]), color="k", linestyle="--")
    axes.plot(grid, curves[0](grid), "C1-.", label="first estimate")
    axes.plot(grid, curves[1](grid), "C0", label="last estimate")
    axes.axvline(peak, color="C0")
    top = 1.2 * float(burckhardt.peak(theta)[1])
    axes.set(xlabel="slip [-]", ylabel="friction coefficient [-]", ylim=(-0.1 * top, top))
    axes.legend(loc="lower right")


def _draw_history(axes: Axes, answers: list[CurveEstimate | Refusal], lambda_max: float) -> None:
    value = np.array([a.lambda_max if isinstance(a, CurveEstimate) else np.nan for a in answers])
    stddev = np.array([a.lambda_max_stddev if isinstance(a, CurveEstimate) else np.nan for a in answers])
    number = np.arange(1, SAMPLES + 1)
    axes.axhspan(0.95 * lambda_max, 1.05 * lambda_max, color="0.85", label="5 % band")
    first = int(np.argmax(np.isfinite(value))) if np.isfinite(value).any() else SAMPLES
    axes.axvspan(1, first + 1, color="0.6", label="initialisation")
    axes.axhline(lambda_max, color="k", linestyle="--", label="true")
    axes.plot(number, value, "C0", label="estimate")
    axes.fill_between(
        number, value - 1.96 * stddev, value + 1.96 * stddev, color="C0", alpha=0.2, label="95 % interval"
    )
    axes.set(xlabel="samples", ylabel="lambda_max [-]", xlim=(1, SAMPLES), ylim=(0.0, 2.0 * lambda_max))
    axes.legend(loc="upper right", fontsize="small")
