"""Figures 8.2 to 8.4 and the mean slip at detection, on simulated counterparts of the chapter's two roads."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from friction_evaluation.closed_loop.braked_corners import BrakedCorners
from friction_evaluation.closed_loop.controller import processors, shipped
from friction_evaluation.protocol import DT
from friction_evaluation.report.page import Picture, Section, Table
from friction_evaluation.rows import Row
from friction_evaluation.slope.detection import METHODS, detect, shipped_settings
from friction_evaluation.slope.runs import Run, through_the_peak
from vehicle_models import burckhardt
from vehicle_models.sensor_noise import CHAPTER_NOISE
from vehicle_models.surfaces import surface

Array = NDArray[np.float64]

ROADS = ("high_grip", "off_road")
CHAPTER_SLIP = {
    ("high_grip", "slip"): 0.0854,
    ("off_road", "slip"): 0.1357,
    ("high_grip", "no_slip"): 0.0648,
    ("off_road", "no_slip"): 0.1283,
}
"""Mean slip at detection that section 8.2.3 reports for its test drives."""
_FIRST_SEED = 40_000
_CYCLES = 2.0
"""Time of the closed loop shown [s]."""
_TEXT = """The chapter's test drives are not public: these are simulated stops on roads with its lambda_max
(0.1 and 0.13), sensors with the noise of section 8.3.2 and the processors with their shipped parameters.

Both methods find the peak on both roads, as in the chapter. The chapter's mean slips at detection lie below
the peak of its high-grip road (0.0854 and 0.0648 against 0.1), that is, detection came before the peak; ours
come at the peak or after it, because the slip at a crossing is compensated for the delay of the filter and
the threshold is set against early alarms. Without slip, our detection comes at the same slip as with it,
because eta and the slip rate agree except in the first and last milliseconds of a braking, where the dead
zone keeps the sign."""


def section(directory: Path, seeds: int) -> Section:
    """Make the runs, `seeds` for each road, and draw into `directory`."""
    settings = shipped_settings(imu=True)
    rows: list[Row] = []
    pictures: list[Picture] = []
    for road in ROADS:
        run = through_the_peak(road)
        found = [detect(run, settings, CHAPTER_NOISE, _FIRST_SEED + seed) for seed in range(seeds)]
        for number, method in zip((2, 3), METHODS, strict=True):
            slips = np.array([each[method].slip for each in found])
            rows.append(
                {
                    "road": road,
                    "method": method,
                    "runs": seeds,
                    "lambda_max": run.lambda_max,
                    "mean slip at detection": float(np.nanmean(slips)),
                    "the chapter's": CHAPTER_SLIP[road, method],
                    "missed": int(np.isnan(slips).sum()),
                }
            )
            file = directory / f"figure_8_{number}_{road}.png"
            _draw_detection(run, found[0][method].signs, file)
            pictures.append(Picture(f"Figure 8.{number}, {road}: slip and detection, method {method}", file))
        file = directory / f"figure_8_4_{road}.png"
        _draw_loop(road, file)
        pictures.append(Picture(f"Figure 8.4, {road}: closed loop, both directions of crossing", file))
    return Section("slope", "Slope sign, Figures 8.2 to 8.4", _TEXT, [Table("Section 8.2.3", rows)], pictures)


def _draw_detection(run: Run, signs: Array, file: Path) -> None:
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(run.time, run.slip, label="slip, true")
    top.axhline(run.lambda_max, color="k", linestyle="--", label="lambda_max, true")
    top.set(ylabel="slip [-]")
    top.legend()
    bottom.step(run.time[: len(signs)], signs, where="post", label="sign of the slope, estimated")
    bottom.step(run.time, np.sign(run.lambda_max - run.slip), "k--", where="post", label="true")
    bottom.set(xlabel="time [s]", ylabel="sign [-]", yticks=(-1, 0, 1))
    bottom.legend()
    figure.savefig(file, dpi=110)


def _draw_loop(road: str, file: Path) -> None:
    """Brake with the supervisor in the loop and draw slip, sign and state."""
    braked = BrakedCorners(road, range(_FIRST_SEED, _FIRST_SEED + 1), partial(processors, parameters=shipped()))
    plant = braked.plant
    running = np.ones(1, dtype=bool)
    kept: list[tuple[float, float, int]] = []
    for _ in range(round(_CYCLES / DT)):
        (command,) = braked.brake(running)
        kept.append((float(plant.corner.slip[0]), float(plant.torque[0]), int(command)))
    slip, torques, commands = np.array(kept).T
    time = DT * np.arange(1, len(kept) + 1)
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    axes[0].plot(time, slip, label="slip, true")
    axes[0].axhline(float(burckhardt.peak(surface(road))[0]), color="k", linestyle="--", label="lambda_max, true")
    axes[0].set(ylabel="slip [-]")
    axes[1].step(time, commands, where="post", label="command: 0 none, 1 increase, 3 decrease")
    axes[1].set(ylabel="command [-]")
    axes[2].plot(time, torques, label="brake torque")
    axes[2].set(xlabel="time [s]", ylabel="torque [N m]")
    for axis in axes:
        axis.legend(loc="lower right")
    figure.savefig(file, dpi=110)
