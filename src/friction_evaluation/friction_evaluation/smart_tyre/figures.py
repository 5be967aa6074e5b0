"""Figures 8.16 and 8.18 to 8.28 from simulated drives."""

from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from friction_evaluation.smart_tyre.runs import (
    LOW,
    NOMINAL,
    RING,
    TRACKER,
    WHEEL,
    CalibrationRuns,
    passages,
    simulate,
    wheel_angle,
)
from friction_evaluation.smart_tyre.runs import NOISY as SENSORS
from smart_tyre_forces.calibrate import raw_points
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.calibration_plots import quasi_static_maps
from smart_tyre_forces.correction import Patch, PatchCorrection
from smart_tyre_forces.fronts import LEVEL, find_fronts
from smart_tyre_forces.reasons import PatchReason
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.force_history import CAR, dynamic_drive
from vehicle_models.tyre_signal import TyreBlock

Array = NDArray[np.float64]

_SEED = 7
_ACCELERATION = (12.0, 22.0)
"""Part of the dynamic drive shown in Figure 8.24 [s]."""


def draw(directory: Path, runs: CalibrationRuns) -> None:
    """Write all figures as PNG files into `directory`, calibrated with `runs`."""
    directory.mkdir(parents=True, exist_ok=True)
    known = runs.calibrate()
    tables = {axle: ToothTable(np.asarray(wheel.tooth_table)) for axle, wheel in known.wheels.items()}
    block = simulate(dynamic_drive(road_seed=_SEED), "front", _SEED)
    _raw_signal(block, directory / "figure_8_16.png")
    _encoder(block, tables["front"], directory / "figure_8_18.png")
    _fronts(block, tables["front"], directory / "figure_8_19.png")
    points = {f"{r.wheel.name}, run {k}": raw_points(r, CAR, TRACKER) for k, r in enumerate(runs.quasi_static)}
    quasi_static_maps(points, known.tyre, directory / "figure_8_21.png")
    rear, front = (_patches(axle, known, tables[axle], NOMINAL) for axle in ("rear", "front"))
    _experiment(rear, _raw, "rear wheel, as measured", directory / "figure_8_20.png")
    for number, found, name in ((22, rear, "rear"), (23, front, "front")):
        title = f"{name} wheel, speed trend removed"
        _experiment(found, lambda p: _detrended(p, known), title, directory / f"figure_8_{number}.png")
    _cross_talk(front, known, directory / "figure_8_24.png")
    for number, axle, pressure in (
        (25, "rear", NOMINAL),
        (26, "front", NOMINAL),
        (27, "rear", LOW),
        (28, "front", LOW),
    ):
        found = _patches(axle, known, tables[axle], pressure)
        title = f"{axle} wheel, {pressure / 1e5:.1f} bar, all corrections"
        _experiment(found, _final, title, directory / f"figure_8_{number}.png")


def _patches(axle: str, known: Calibration, table: ToothTable, pressure: float) -> list[Patch]:
    block = simulate(dynamic_drive(road_seed=_SEED), axle, _SEED, SENSORS, pressure)
    correction = PatchCorrection(known.tyre, WHEEL.radius, TRACKER.sample_rate)
    patches = [correction.update(passage) for passage in passages(block, table)]
    return [patch for patch in patches if patch.reason is PatchReason.OK]


def _time(patches: list[Patch]) -> Array:
    return np.array([p.passage.time / TRACKER.sample_rate for p in patches])


def _raw(patches: list[Patch]) -> tuple[Array, Array]:
    return np.array([p.shift_raw for p in patches]), np.array([p.length_raw for p in patches])


def _final(patches: list[Patch]) -> tuple[Array, Array]:
    return np.array([p.shift for p in patches]), np.array([p.length for p in patches])


def _detrended(patches: list[Patch], known: Calibration) -> tuple[Array, Array]:
    """Without the correction for load (8.19)."""
    shift, length = _final(patches)
    return shift - known.tyre.beta * (length - known.tyre.nominal_length), length


def _finish(figure: Figure, axes: list[Axes], labels: list[tuple[str, str]], file: Path) -> None:
    for axis, (x, y) in zip(axes, labels, strict=True):
        axis.set_xlabel(x)
        axis.set_ylabel(y)
        axis.grid(True)
    figure.tight_layout()
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _raw_signal(block: TyreBlock, file: Path) -> None:
    figure, axis = plt.subplots(figsize=(8.0, 4.0))
    part = slice(300_000, 307_000)
    axis.plot(np.arange(7000) / 1e4, block.radial_acceleration[part] / 9.81, linewidth=0.6)
    _finish(figure, [axis], [("time [s]", "radial acceleration [g]")], file)


def _encoder(block: TyreBlock, table: ToothTable, file: Path) -> None:
    figure, axes = plt.subplots(3, 1, figsize=(8.0, 9.0))
    axes[0].plot(np.arange(1000) / 1e4, block.encoder_voltage[50_000:51_000])
    wheel = wheel_angle(block, table)
    turn = len(table)
    speed = (wheel.angles[turn:] - wheel.angles[:-turn]) / (wheel.times[turn:] - wheel.times[:-turn])
    axes[1].plot(wheel.times[turn // 2 : -turn // 2] / 1e4, speed * TRACKER.sample_rate * RING.radius)
    samples = np.arange(50_000.0, 60_000.0, dtype=np.float64)
    axes[2].plot((samples - samples[0]) / 1e4, np.degrees(np.mod(wheel.at(samples), 2.0 * np.pi)))
    labels = [("time [s]", "encoder [V]"), ("time [s]", "wheel speed [m/s]"), ("time [s]", "wheel angle [deg]")]
    _finish(figure, list(axes), labels, file)


def _fronts(block: TyreBlock, table: ToothTable, file: Path) -> None:
    wheel = wheel_angle(block, table)
    first = passages(block, table)[100]
    centre = 0.5 * (first.alpha_1 + first.alpha_2)
    turns = np.round((float(wheel.at(np.array([first.time]))[0]) - centre) / (2.0 * np.pi))
    begin, end = (wheel.time_of(centre + 2.0 * np.pi * turns + a) for a in (-np.pi, np.pi))
    samples: Array = np.arange(np.ceil(begin), np.floor(end)).astype(np.float64)
    theta = wheel.at(samples) - centre - 2.0 * np.pi * turns
    signal = block.radial_acceleration[samples.astype(np.int64)].astype(np.float64)
    found = find_fronts(theta, signal, float(np.mean(signal[theta < -np.radians(50.0)])), 1.0)
    assert found is not None
    normalised = (signal - found.floor) / found.step - LEVEL
    figure, axis = plt.subplots(figsize=(8.0, 4.0))
    angle = np.degrees(theta + centre)
    axis.plot(angle, normalised, linewidth=0.8, label="normalised, detrended signal")
    inside = (theta > found.alpha_1) & (theta < found.alpha_2)
    axis.plot(angle, np.where(inside, -LEVEL, 1.0 - LEVEL), ":", label="front detection")
    axis.plot(np.degrees(centre + np.array([found.alpha_1, found.alpha_2])), [0.0, 0.0], "o", label="fronts")
    axis.legend()
    _finish(figure, [axis], [("wheel angle [deg]", "-")], file)


def _experiment(patches: list[Patch], select: object, title: str, file: Path) -> None:
    assert callable(select)
    shift, length = select(patches)
    time, speed = _time(patches), np.array([p.speed for p in patches])
    figure, axes = plt.subplots(3, 1, figsize=(8.0, 8.0), sharex=True)
    for axis, values in zip(axes, (speed, np.degrees(shift), np.degrees(length)), strict=True):
        axis.plot(time, values, linewidth=0.8)
    axes[0].set_title(title)
    labels = [("", "wheel speed [m/s]"), ("", "phase shift [deg]"), ("time [s]", "patch length [deg]")]
    _finish(figure, list(axes), labels, file)


def _cross_talk(patches: list[Patch], known: Calibration, file: Path) -> None:
    time = _time(patches)
    shown = (time > _ACCELERATION[0]) & (time < _ACCELERATION[1])
    figure, axes = plt.subplots(3, 1, figsize=(8.0, 8.0), sharex=True)
    axes[0].plot(time[shown], np.array([p.speed for p in patches])[shown])
    for axis, (shift, _) in zip(axes[1:], (_detrended(patches, known), _final(patches)), strict=True):
        axis.plot(time[shown], np.degrees(shift[shown]))
        axis.set_ylim(-0.6, 0.6)
    axes[0].set_title(f"front wheel, before and after the correction for load, beta = {known.tyre.beta:.3f}")
    labels = [("", "wheel speed [m/s]"), ("", "shift before [deg]"), ("time [s]", "shift after [deg]")]
    _finish(figure, list(axes), labels, file)
