"""Plots of a calibration: the quasi-static maps of Figure 8.21 and the force maps (8.14), (8.16)."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from smart_tyre_forces.calibrate import Points
from smart_tyre_forces.calibration import TyreCalibration, polynomial


def quasi_static_maps(points: dict[str, Points], tyre: TyreCalibration, file: Path) -> None:
    """Plot Figure 8.21: shift and length over speed, with their maps. `points` has one entry per run, by label.

    The zero of the shift is a convention of each run: each is drawn with its mean on the map.
    """
    figure, axes = plt.subplots(2, 1, figsize=(7.0, 8.0), sharex=True)
    every = np.concatenate([p.speed for p in points.values()])
    speeds = np.linspace(float(np.min(every)), float(np.max(every)), 100)
    for label, p in points.items():
        zero = float(np.mean(p.shift - [polynomial(tyre.shift_trend, float(v)) for v in p.speed]))
        axes[0].plot(p.speed, np.degrees(p.shift - zero), ".", markersize=2, label=label)
        axes[1].plot(p.speed, np.degrees(p.length), ".", markersize=2)
    for axis, trend, name in (
        (axes[0], tyre.shift_trend, "phase shift [deg]"),
        (axes[1], tyre.length_trend, "contact patch length [deg]"),
    ):
        axis.plot(speeds, np.degrees([polynomial(trend, float(v)) for v in speeds]), "k-", label="second-order map")
        axis.set_ylabel(name)
        axis.grid(True)
    axes[0].legend()
    axes[1].set_xlabel("wheel speed [m/s]")
    figure.savefig(file, dpi=120, bbox_inches="tight")
    plt.close(figure)


def force_maps(points: dict[str, Points], tyre: TyreCalibration, file: Path) -> None:
    """Plot Fz over length and Fx over shift: passages of the dynamic runs against their reference, with the maps."""
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.5))
    for label, p in points.items():
        axes[0].plot(np.degrees(p.length), p.fz, ".", markersize=3, label=label)
        axes[1].plot(np.degrees(p.shift), p.fx, ".", markersize=3, label=label)
    for axis, force_map, name in (
        (axes[0], tyre.length_map, ("length [deg]", "Fz [N]")),
        (axes[1], tyre.shift_map, ("shift [deg]", "Fx less the steady part [N]")),
    ):
        force = np.linspace(force_map.lowest, force_map.highest, 100)
        axis.plot(np.degrees(force_map.angle(force)), force, "k-", label="map")
        axis.set_xlabel(name[0])
        axis.set_ylabel(name[1])
        axis.grid(True)
        axis.legend()
    figure.savefig(file, dpi=120, bbox_inches="tight")
    plt.close(figure)
