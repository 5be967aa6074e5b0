"""Figures 8.10 to 8.13: lambda_max against samples, with measured and with estimated vehicle speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from friction_evaluation.report.page import Picture
from friction_evaluation.slip import tables
from friction_evaluation.slip.following import shipped
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

_FIGURES = (
    (10, 0, "rls", "measured"),
    (11, 1, "rml_ml", "measured"),
    (12, 0, "rls", "estimated"),
    (13, 1, "rls", "estimated"),
)
"""Number, road, method, speed."""
_SEED = 41_000


def pictures(directory: Path) -> list[Picture]:
    """Draw the four figures into `directory`, one run each."""
    found = []
    for number, road, method, speed in _FIGURES:
        file = directory / f"figure_8_{number}.png"
        _draw(tables.ROADS[road], method, speed, file)
        text = f"Figure 8.{number}: {method}, {tables.ROADS[road].name}, {speed} vehicle speed"
        found.append(Picture(text, file))
    return found


def _draw(road: tables.Road, method: str, speed: str, file: Path) -> None:
    slip, value = tables.history(road, method, speed, _SEED, shipped())
    number = np.arange(1, len(slip) + 1)
    lambda_max = float(burckhardt.peak(surface(road.name))[0])
    figure = Figure(figsize=(8.0, 5.5), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(number, slip, label=f"slip from {speed} speed")
    top.axhline(tables.ACTIVATION_SLIP, color="k", linestyle="--", label="ABS activation")
    top.set(ylabel="slip [-]")
    bottom.axhspan(0.95 * lambda_max, 1.05 * lambda_max, color="0.85", label="5 % band")
    bottom.axhline(lambda_max, color="k", linestyle="--", label="lambda_max, true")
    bottom.plot(number, value, label=f"lambda_max, {method}")
    bottom.set(xlabel="samples since brake onset", ylabel="lambda_max [-]", ylim=(0.0, 2.0 * lambda_max))
    for axis in (top, bottom):
        axis.legend(loc="lower right")
    figure.savefig(file, dpi=110)
