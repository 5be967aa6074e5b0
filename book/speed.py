"""Section 8.3.3: Tables 8.4 and 8.5, Figures 8.9 to 8.13: lambda_max of a car, with either speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.runner import Row
from benchmarks.slip.stops import shipped
from book.chapter_numbers import ERRORS_ON_ROADS, compared, spread_of
from book.driver_stop import ROADS, StopRun, figure_8_9, stop_run
from book.page import Picture, Section, Table
from book.speed_tables import ACTIVATION_SLIP, LAMBDA_INIT, tables
from book.speed_tables import ROADS as CHAPTER_ROADS
from friction_curve_id.chapter.curve_fitting import PointFitting
from friction_curve_id.chapter.start_parameters import StartParameters
from friction_curve_id.interface import CurveEstimate
from friction_curve_id.methods import CHAPTER_METHODS

Array = NDArray[np.float64]

_FIGURES = (
    (10, "high grip", "rls", "measured"),
    (11, "low grip", "rml_ml", "measured"),
    (12, "high grip", "rls", "estimated"),
    (13, "low grip", "rls", "estimated"),
)
"""Number, road, method, speed."""
_SEED = 41_000
_TABLES_SEED = 30_000
_STOPS = 20
"""Driver's stops of each road."""
_FEWEST = 20
"""Runs for a middle 90 %."""
_TEXT = f"""The roads have the chapter's lambda_max, 0.1 and 0.13, and its numbers of samples from lambda_init =
{LAMBDA_INIT} to the ABS activation at {ACTIVATION_SLIP}. Start: the fit begins beyond lambda_init with all samples of
the braking (all) or only with those beyond it (beyond). The driver's stops are of a car whose load moves and whose
tyres relax; their samples are made with the load from the acceleration."""
_ALL_SAMPLES = StartParameters(LAMBDA_INIT)


@dataclass(frozen=True)
class Followed:
    """lambda_max over the friction samples of a stop, shape (samples,)."""

    number: NDArray[np.int64]
    """Samples since the brake onset."""
    lambda_max: Array
    """NaN before the fit begins."""
    activation: int
    """Index of the first sample whose true slip is beyond that of the ABS activation."""

    def errors(self, truth: float) -> tuple[float, float]:
        """Errors at activation and at the end [%]; NaN where there is no estimate."""
        at = self.lambda_max[[self.activation, -1]]
        first, last = (100.0 * (float(value) / truth - 1.0) for value in at)
        return first, last


def follow(run: StopRun, method: str, speed: str) -> Followed:
    """Feed a method of the chapter with the friction samples of a stop, at the load from the acceleration."""
    fitting = PointFitting(CHAPTER_METHODS[method](), _ALL_SAMPLES)
    samples = run.friction_samples(speed == "estimated", moving_load=True)
    answers = [fitting.update(point) for _, point in samples]
    found = np.array([answer.lambda_max if isinstance(answer, CurveEstimate) else np.nan for answer in answers])
    numbers = np.array([number for number, _ in samples])
    activation = int(np.argmax(run.slip[numbers] > ACTIVATION_SLIP))
    return Followed(numbers - run.onset, found, activation)


def section(directory: Path, seeds: Callable[[int], int]) -> Section:
    """Make the runs and draw into `directory`."""
    runs = max(seeds(100), _FEWEST)
    rows = tables(range(_TABLES_SEED, _TABLES_SEED + runs), shipped())
    samples, picture = figure_8_9(directory)
    shown = [
        Table("Tables 8.4 and 8.5 in simulation, errors of lambda_max", rows),
        Table(
            "The same on the driver's stops, of which Figures 8.10 to 8.13 show one each", stop_rows(min(runs, _STOPS))
        ),
        samples,
    ]
    title = "On a car, with and without a speed sensor, Tables 8.4 and 8.5, Figures 8.9 to 8.13"
    return Section("8.3.3", title, _TEXT, shown, [picture, *pictures(directory)], numbers(rows))


def numbers(rows: Sequence[Row]) -> list[Row]:
    """Compare the errors of Tables 8.4 and 8.5."""
    found = []
    for row in rows:
        table, road = str(row["case"]).split(", ")
        chapter = ERRORS_ON_ROADS.get((road, row["method"], row["speed"]))
        if chapter is not None and row["start"] == "all":
            what = f"error of lambda_max by {row['method']}, {road}, {row['speed']} speed, {row['instant']} [%]"
            found.append(compared(table, what, chapter[row["instant"] == "end"], spread_of(row, "percent")))
    return found


def stop_rows(seeds: int) -> list[Row]:
    """Rows by road, method and speed of the stops: median errors [%] at activation and at the end, and failures."""
    rows: list[Row] = []
    for road, name in ROADS.items():
        for method in ("rls", "rml_ml"):
            for speed in ("measured", "estimated"):
                runs = [stop_run(name, _SEED + seed) for seed in range(seeds)]
                errors = np.array([follow(run, method, speed).errors(run.truth.lambda_max) for run in runs])
                row: Row = {"stop": road, "method": method, "speed": speed, "runs": seeds}
                for column, instant in enumerate(("activation", "end")):
                    sizes = np.where(np.abs(errors[:, column]) <= 50.0, np.abs(errors[:, column]), np.nan)
                    known = sizes[np.isfinite(sizes)]
                    row[f"median |error| at {instant} [%]"] = float(np.median(known)) if known.size else float("nan")
                    row[f"failures at {instant}"] = seeds - known.size
                rows.append(row)
    return rows


def pictures(directory: Path) -> list[Picture]:
    """Draw the four figures into `directory`, one run each."""
    found = []
    for number, road, method, speed in _FIGURES:
        run = stop_run(ROADS[road], _SEED)
        followed = follow(run, method, speed)
        file = directory / f"figure_8_{number}.png"
        chapter = CHAPTER_ROADS[list(ROADS).index(road)].end
        _draw(run, followed, method, speed, chapter, file)
        first, last = followed.errors(run.truth.lambda_max)
        text = f"""Figure 8.{number}: slip and estimated lambda_max, {method}, {road}, {speed} vehicle speed, on the
        driver's stop. Grey: before the slip is beyond {LAMBDA_INIT}; green: where the chapter's {chapter} samples end,
        as it does not say where they begin. Error {first:+.0f} % where an ABS would act, {last:+.0f} % at the
        largest slip"""
        found.append(Picture(" ".join(text.split()), file))
    return found


def _draw(run: StopRun, followed: Followed, method: str, speed: str, chapter: int, file: Path) -> None:
    number, lambda_max = followed.number, run.truth.lambda_max
    braked = number >= 0
    last = int(number[-1])
    figure = Figure(figsize=(8.0, 5.5), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    samples = run.onset + number[braked]
    if speed == "estimated":
        top.plot(number[braked], run.estimated_slip[samples], "C1", label="slip, estimated")
    top.plot(number[braked], run.slip[samples], "C0", label="slip, true")
    top.axhline(ACTIVATION_SLIP, color="k", linestyle="--", linewidth=0.8, label="ABS activation")
    top.set(ylabel="slip [-]")
    bottom.axhspan(0.95 * lambda_max, 1.05 * lambda_max, color="0.85", label="5 % band")
    bottom.axhline(lambda_max, color="k", linestyle="--", linewidth=0.8, label="lambda_max, true")
    bottom.plot(number[braked], followed.lambda_max[braked], "C0", label=f"lambda_max, {method}")
    begun = np.flatnonzero(np.isfinite(followed.lambda_max))
    first = int(number[begun[0]]) if begun.size else last
    bottom.axvspan(0, first, color="0.7", label="initialisation")
    for axis in (top, bottom):
        for begin, style, of in ((0, ":", "onset"), (first, "-.", "lambda_init")):
            if begin + chapter <= last:
                axis.axvline(begin + chapter, color="C2", linestyle=style, label=f"{chapter} samples from {of}")
        axis.axvline(number[followed.activation], color="C3", linewidth=0.8, label="activation")
        axis.legend(loc="upper left", fontsize="x-small")
    bottom.set(
        xlabel="samples since brake onset", ylabel="lambda_max [-]", ylim=(0.0, 2.0 * lambda_max), xlim=(0, last)
    )
    figure.savefig(file, dpi=110)
