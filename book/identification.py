"""Section 8.3.2: Tables 8.1 to 8.3, readings of the chapter, and Figures 8.5 to 8.8."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.identification.part import on_roads, seeds_of
from benchmarks.identification.runs import Batch, measured
from benchmarks.protocol import CORNER, SAMPLES
from benchmarks.runner import Row, as_text, rows_of
from book.chapter_numbers import NAN, SAMPLES_WITHIN, Spread, compared, spread_of
from book.page import Picture, Section, Table
from book.tables import READINGS, begun, chapter_tables, completed, friction_points, readings
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import CurveEstimate, Refusal
from friction_curve_id.methods import exact_wheel_estimator
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
                _draw_fit(left, points, _curves(method, points), peak, truth.theta[surface])
                _draw_history(right, answers, float(burckhardt.peak(truth.theta[surface])[0]))
                figure.suptitle(f"{method} on {name}, manoeuvre {_MANOEUVRE}")
                path = directory / f"identification_{_MANOEUVRE}_{name}_{method}.png"
                figure.savefig(path, dpi=120)
                error = 100.0 * (peak / float(burckhardt.peak(truth.theta[surface])[0]) - 1.0)
                rows.append({"surface": name, "method": method, "error_pct": error, "figure": str(path)})
                progress.advance(bar)
    return rows


def _curves(method: str, points: tuple[Array, Array]) -> tuple[Curve, Curve]:
    """Return the first and the last curve that a method fitted."""
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


_FIRST = "cobblestone"
"""The chapter's figures are of this road."""
_FIGURES = {"rml": "Figures 8.5, 8.6", "rls": "Figures 8.7, 8.8"}
_PLACES = {"ml": "Table 8.2", "rml": "Table 8.2", "ls": "Table 8.3"}
_METHODS = ("rml", "rls", "ml", "rml_ml")
_OURS = next(iter(READINGS))
_FEWEST = 20
"""Runs for a middle 90 %."""
_TEXT = """The chapter prints one noisy run for each surface. The methods take friction samples by dead-reckoned
speed. It leaves open how its samples were smoothed and how fast the brake was applied: the first table has other
readings beside ours. Equation (8.11) is used with the factor 1/2 of its quadratic term, without which it diverges;
rml_covariance is RML in covariance form."""


def section(pictures: Path, seeds: Callable[[int], int]) -> Section:
    """Make the runs and draw into `pictures`."""
    drawn = figures(pictures, _METHODS)
    read = readings(max(seeds(300), _FEWEST))
    study = ("benchmarks", "identification", "--seeds", str(seeds(500)), "--methods", "rml", "rls", "--manoeuvre")
    kept = kept_rows([row for manoeuvre in "BC" for row in rows_of(*study, manoeuvre)])
    shown = [
        Table("Which reading gives which number: |error| of lambda_max [%], median (5 to 95 %)", by_number(read)),
        Table("Sample from which the error of lambda_max stays within 10 % and 5 % (median of the runs)", kept),
        Table("Tables 8.1 to 8.3, medians over the runs beside the chapter's", chapter_tables(seeds(500))),
    ]
    ordered = sorted((_picture(row) for row in drawn), key=lambda picture: bool(picture.fold))
    title = "Identification of the friction curve, Tables 8.1 to 8.3, Figures 8.5 to 8.8"
    return Section("8.3.2", title, _TEXT, shown, ordered, numbers(read, kept))


def numbers(read: Sequence[Row], kept: Sequence[Row]) -> list[Row]:
    """Compare the errors of Tables 8.2 and 8.3, and the samples of Figures 8.6 and 8.8."""
    found = []
    for row in read:
        if row["reading"] == _OURS and row["method"] in _PLACES:
            what = f"|error| of lambda_max by {row['method']} on {row['surface']} [%]"
            found.append(compared(_PLACES[row["method"]], what, row["chapter_pct"], spread_of(row, "pct")))
    by = {(row["method"], row["within [%]"]): row for row in kept if row["manoeuvre"] == "B"}
    for (method, limit), chapter in SAMPLES_WITHIN.items():
        what = f"{method} within {limit} % on {_FIRST}, from sample"
        found.append(
            compared(
                "Figure 8.6" if method == "rml" else "Figure 8.8",
                what,
                chapter,
                Spread(NAN, float(by[method, limit][_FIRST]), NAN),
            )
        )
    return found


def by_number(rows: Sequence[Row]) -> list[Row]:
    """Rows of the study `readings` with the readings side by side, and those whose runs hold the chapter's number."""
    found: dict[tuple[str, str], Row] = {}
    for row in rows:
        number = found.setdefault(
            (row["method"], row["surface"]),
            {"method": row["method"], "road": row["surface"], "chapter": row["chapter_pct"]},
        )
        low, median, high = (row[name] for name in ("p5_pct", "median_pct", "p95_pct"))
        number[row["reading"]] = f"{as_text(median)} ({as_text(low)} to {as_text(high)})"
        gives = str(number.get("given by", ""))
        if low <= row["chapter_pct"] <= high:
            gives = f"{gives}; {row['reading']}" if gives else row["reading"]
        number["given by"] = gives
    order = ["method", "road", "chapter", *READINGS, "given by"]
    return [{name: row.get(name) for name in order} for row in found.values()]


def kept_rows(rows: Sequence[Row]) -> list[Row]:
    """Rows by method with the roads side by side, from those of the study `methods`."""
    found: dict[tuple[str, str, int], Row] = {}
    for row in rows:
        for limit in (10, 5):
            head = {"method": row["method"], "manoeuvre": row["manoeuvre"], "within [%]": limit}
            line = found.setdefault((row["method"], row["manoeuvre"], limit), head)
            line[row["surface"]] = row[f"kept_{limit}pct_from"]
    return list(found.values())


def _picture(row: Row) -> Picture:
    method, road = row["method"], row["surface"]
    number = f"{_FIGURES[method]}: " if method in _FIGURES else ""
    error = row["error_pct"]
    ends = "gives no peak" if error != error else f"ends {error:+.1f} % from the true lambda_max"
    caption = f"{number}{method} on {road}: fit to the samples (left), lambda_max against samples (right); {ends}"
    shown_first = road == _FIRST and method in _FIGURES
    return Picture(caption, Path(row["figure"]), "" if shown_first else "Other methods and roads")
