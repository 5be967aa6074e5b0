"""Figures 8.2 to 8.4 on the driver's stops, and the mean slip at detection as shipped and as printed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.rows import Row
from benchmarks.slope.detection import METHODS, detect, shipped_settings, through_the_peak
from book import slope_verdicts
from book.as_printed import VARIANTS, slips_at_detection
from book.page import Picture, Section, Table
from book.stop_run import ROADS, StopRun, stop_run
from corner_sim.sensors import CHAPTER_NOISE

Array = NDArray[np.float64]

CHAPTER_SLIP = {
    ("high_grip", "slip"): 0.0854,
    ("off_road", "slip"): 0.1357,
    ("high_grip", "no_slip"): 0.0648,
    ("off_road", "no_slip"): 0.1283,
}
"""Mean slip at detection that section 8.2.3 reports for its test drives."""
EQUATIONS = {"slip": "(8.4)", "no_slip": "(8.5)"}
PRINTED = {
    f"printed: {v.window} samples, T_b above {v.least_torque:.0f} N m": variant for variant, v in enumerate(VARIANTS)
}
"""Columns of the table, and the variant of each."""
_FIRST_SEED = 40_000
_SHOWN = (0.4, 2.2)
"""Time of a stop in the figures [s]."""
_TEXT = """The chapter's test drives are not public: these are simulated stops on roads with its lambda_max
(0.1 and 0.13) and with the noise of section 8.3.2. The figures show a driver's stop of a car with load transfer,
springs and tyres that relax. The table is of one corner whose torque is built up in 0.25 s, held until twice
lambda_max and released.

What friction_slope ships has a dead zone for the slip rate, leaves out the interval of (8.6), and waits for slip
that grows beyond the noise; the slip at a crossing is compensated for the delay of the filter. So both equations
detect together, at the peak or a little after it. The printed equations have one negative threshold (here -15
rad/s^3) and nothing else. They come nearer to the chapter's means, which lie before the peak of its high-grip road,
where a part of the detections is early: right at the onset, as long as slip rate and eta are noise (a torque
threshold of 30 N m), or before the peak, where H of a short window falls below the threshold by its noise. The
column "early" counts both."""


def section(directory: Path, seeds: int) -> Section:
    """Make the runs, `seeds` for each road, and draw into `directory`."""
    rows = mean_slips(seeds)
    runs = {road: stop_run(name, _FIRST_SEED) for road, name in ROADS.items()}
    pictures = []
    for number, column, method in ((2, 0, "slip"), (3, 1, "no_slip")):
        file = directory / f"figure_8_{number}.png"
        _draw_detection(runs, column, file)
        known = "with the slip known" if method == "slip" else "from wheel speed and brake pressure alone"
        seen = "; ".join(f"{road}: {_seen(run, column)}" for road, run in runs.items())
        pictures.append(Picture(f"Figure 8.{number}: sign of the slope by {EQUATIONS[method]}, {known}. {seen}", file))
    file = directory / "figure_8_4.png"
    _draw_both_directions(runs, file)
    text = """Figure 8.4: slip (solid) and detection by (8.5) (dashed: high while the wheel is held to be beyond the
    peak). The sign falls after the slip has passed lambda_max, and returns after the driver has let go of the brake"""
    pictures.append(Picture(" ".join(text.split()), file))
    table = Table("Section 8.2.3: mean slip at the first detection, and share of the runs in which it came early", rows)
    title = "Slope sign, Figures 8.2 to 8.4"
    return Section("slope", title, _TEXT, [table], pictures, slope_verdicts.mean_slips(rows))


def mean_slips(seeds: int) -> list[Row]:
    """Rows by road and equation: mean slip at the first detection [-], shipped and printed, and what came early [%]."""
    settings = shipped_settings(imu=True)
    rows: list[Row] = []
    for road in ("high_grip", "off_road"):
        run = through_the_peak(road)
        numbers = range(_FIRST_SEED, _FIRST_SEED + seeds)
        shipped = [detect(run, settings, CHAPTER_NOISE, seed) for seed in numbers]
        printed = np.array([slips_at_detection(run, VARIANTS, settings.slip, seed) for seed in numbers])
        for column, method in enumerate(METHODS):
            ours = np.array([found[method].slip for found in shipped])
            lost = np.array([found[method].lost for found in shipped])
            row: Row = {
                "road": road,
                "equation": EQUATIONS[method],
                "runs": seeds,
                "lambda_max": run.lambda_max,
                "chapter": CHAPTER_SLIP[road, method],
                "shipped": float(np.nanmean(ours)),
                "shipped: early [%]": 100.0 * float(np.mean(lost < run.crossings()[0])),
                "shipped: missed [%]": 100.0 * float(np.mean(np.isnan(lost))),
            }
            for name, variant in PRINTED.items():
                slips = printed[:, variant, column]
                row[name] = float(np.nanmean(slips))
                row[f"{name}: early [%]"] = 100.0 * float(np.mean(slips < run.lambda_max))
            rows.append(row)
    return rows


def _seen(run: StopRun, column: int) -> str:
    lost = run.truth.time[np.argmax(run.signs[:, column] < 0)]
    return f"detected {1e3 * (lost - run.truth.up):.0f} ms after the slip has passed lambda_max"


def _draw_detection(runs: Mapping[str, StopRun], column: int, file: Path) -> None:
    figure = Figure(figsize=(11.0, 5.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex="col")
    for (road, run), (top, bottom) in zip(runs.items(), axes.T, strict=True):
        _draw_slip(top, run)
        top.set_title(f"({'ab'[list(runs).index(road)]}) {road}")
        sign = np.sign(run.truth.lambda_max - run.slip)
        bottom.step(run.truth.time, run.signs[:, column], where="post", label="estimated (0: not known)")
        bottom.step(run.truth.time, sign, "k--", where="post", linewidth=0.8, label="true")
        bottom.set(xlabel="time [s]", ylabel="sign of the slope", yticks=(-1, 0, 1))
        bottom.set_xlim(_SHOWN)
        bottom.legend(loc="lower right", fontsize="small")
    figure.savefig(file, dpi=110)


def _draw_slip(axes: Axes, run: StopRun) -> None:
    axes.plot(run.truth.time, run.estimated_slip, color="C1", linewidth=0.9, label="slip, estimated")
    axes.plot(run.truth.time, run.slip, color="C0", label="slip, true")
    axes.axhline(run.truth.lambda_max, color="k", linestyle="--", linewidth=0.8, label="lambda_max, true")
    axes.set(ylabel="slip [-]", xlim=_SHOWN)
    axes.legend(loc="upper right", fontsize="small")


def _draw_both_directions(runs: Mapping[str, StopRun], file: Path) -> None:
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    for (road, run), axes in zip(runs.items(), figure.subplots(1, 2), strict=True):
        _draw_slip(axes, run)
        beyond = np.where(run.signs[:, METHODS.index("no_slip")] < 0, run.slip.max(), 0.0)
        axes.step(run.truth.time, beyond, "C3--", where="post", label="detection: beyond the peak")
        axes.set(title=f"({'ab'[list(runs).index(road)]}) {road}", xlabel="time [s]")
        axes.legend(loc="upper right", fontsize="small")
    figure.savefig(file, dpi=110)
