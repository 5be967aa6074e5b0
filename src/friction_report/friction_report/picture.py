"""One picture of a drive, for a README: the page holds everything else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from friction_bags.results.braking_rows import vehicle_speed
from friction_bags.results.brakings import hardest_braking
from friction_bags.results.recorded_run import RecordedRun
from friction_report.drive_series import Line, lines_of
from friction_report.page import PANELS

_PANELS = ("speed", "slip", "lambda_max", "mu_max", "pressure", "grip", "fx", "fz")
_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:brown", "tab:pink", "tab:olive")
_OF_CAR = ("black", "tab:green", "tab:orange", "tab:red")
_STYLES = {"truth": "--", "aim": ":", "demand": "-."}
_MARGIN = 0.5
"""Time [s] shown before and after the hardest braking."""


def write_picture(run: RecordedRun, out: Path, title: str) -> None:
    """Draw the lines of a run over its hardest braking, or over all of it where it does not brake, as a PNG file."""
    drawn = [line for line in lines_of(run) if line.panel in _PANELS and np.any(np.isfinite(line.values))]
    panels = [panel for panel in PANELS if any(line.panel == panel.key for line in drawn)]
    figure = Figure(figsize=(11.0, 1.0 + 2.4 * len(panels)), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    rows: list[Axes] = list(figure.subplots(max(len(panels), 1), 1, sharex=True, squeeze=False)[:, 0])
    for axes, panel in zip(rows, panels, strict=False):
        lines = [line for line in drawn if line.panel == panel.key]
        for line in lines:
            if line.of in run.wheels:
                _draw(axes, line, _COLOURS[run.wheels.index(line.of) % len(_COLOURS)])
        for place, line in enumerate(line for line in lines if line.of not in run.wheels):
            _draw(axes, line, _OF_CAR[place % len(_OF_CAR)])
        axes.set_ylabel(panel.axis)
        axes.grid(visible=True, lw=0.3)
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7)
    rows[-1].set_xlabel("time since the first sample [s]")
    speed = vehicle_speed(run)
    if speed is not None and (span := hardest_braking(*speed)) is not None:
        rows[0].set_xlim(span[0] - _MARGIN, span[1] + _MARGIN)
    figure.savefig(out, dpi=110)


def _draw(axes: Axes, line: Line, colour: str) -> None:
    if line.kind == "points":
        axes.plot(line.time, line.values, ls="", marker="o", ms=3, color=colour, label=line.label)
        return
    axes.plot(line.time, line.values, ls=_STYLES.get(line.kind, "-"), lw=1.0, color=colour, label=line.label)
    if line.band is not None:
        axes.fill_between(line.time, *line.band, color=colour, alpha=0.25, lw=0.0)
