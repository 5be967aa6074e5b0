"""Figure 8.9: measured friction samples overshoot the static curve.

The chapter names the causes: suspension elasticity, by which the load of a front wheel swings beyond its steady value,
and tyre relaxation, by which friction follows the slip with a lag. As there, the theoretical curve holds the steady
load transfer, and the samples are made with the static load.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from friction_evaluation.manoeuvres import braking
from friction_evaluation.protocol import DT
from friction_evaluation.report.page import Picture, Section
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

_CAR = load_vehicle("compact_car")
_RELAXATION_LENGTH = _CAR.wheel("front_left").relaxation_length
"""[m]"""
_LOAD_TRANSFER = _CAR.height_ratio / _CAR.front_load_share
"""The load of a front wheel grows by this share for a deceleration of g [-]."""
_TEXT = f"""The friction samples that a car measures on a front wheel, made with the static load, begin below
the theoretical curve and then overshoot it, as in the chapter's figure: the tyre follows the slip with a
relaxation length of {_RELAXATION_LENGTH} m, and the body pitches beyond its steady angle
({_CAR.pitch_frequency} Hz, damping {_CAR.pitch_damping}), and the load with it. The chapter says that the abscissa of
the peak hardly moves; here the highest sample lies 23 % beyond it, as the top is flat and the load still swings
when the tyre has passed it. The chapter's test drive is not public, this is its simulated
counterpart."""


def section(directory: Path) -> Section:
    """Draw into `directory`."""
    theta = surface("high_grip")
    slip, theory, seen = overshoot(theta)
    figure = Figure(figsize=(7.0, 4.5), layout="constrained")
    axes = figure.subplots()
    axes.plot(slip, seen, ".", label="samples: tyre relaxation, pitching body")
    axes.plot(slip, theory, "r--", label="theoretical curve with the steady load transfer")
    axes.axvline(float(burckhardt.peak(theta)[0]), color="k", linestyle="--", label="lambda_max, true")
    axes.set(xlabel="slip [-]", ylabel="friction coefficient [-]")
    axes.legend()
    file = directory / "figure_8_9.png"
    figure.savefig(file, dpi=110)
    pictures = [Picture("Figure 8.9: friction samples of a front wheel on a high-grip road", file)]
    return Section("friction_samples", "Friction samples on a car, Figure 8.9", _TEXT, pictures=pictures)


def overshoot(theta: Array) -> tuple[Array, Array, Array]:
    """Slip, theoretical friction under the steady load, and friction as sampled; shapes (samples,)."""
    truth = braking("C", theta)
    slip, speed = truth.slip[0], truth.speed[0]
    static = burckhardt.friction(theta, slip)
    friction, swing = np.zeros_like(slip), np.zeros_like(slip)
    rate = 0.0
    frequency, damping = 2.0 * np.pi * _CAR.pitch_frequency, _CAR.pitch_damping
    for k in range(1, len(slip)):
        lag = DT * speed[k] / _RELAXATION_LENGTH
        friction[k] = friction[k - 1] + (static[k] - friction[k - 1]) * -np.expm1(-lag)
        steady = _LOAD_TRANSFER * friction[k]
        pull = frequency**2 * (steady - swing[k - 1]) - 2.0 * damping * frequency * rate
        rate += DT * pull
        swing[k] = swing[k - 1] + DT * rate
    return slip, static * (1.0 + _LOAD_TRANSFER * static), friction * (1.0 + swing)
