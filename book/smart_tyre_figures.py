"""Figures 8.16 and 8.18 to 8.28 from simulated drives, forces beside their truth, and what these figures show."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray

from vehicle_models.reason import Reason

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.runner import Row, not_judged
from benchmarks.smart_tyre.runs import (
    LOW,
    NOMINAL,
    PHASES,
    RING,
    STEADY,
    TRACKER,
    WHEEL,
    CalibrationRuns,
    Estimated,
    estimate,
    means,
    passages,
    simulate,
    wheel_angle,
)
from benchmarks.smart_tyre.runs import NOISY as SENSORS
from corner_sim.smart_tyre.drives import CAR, dynamic_drive
from corner_sim.smart_tyre.tyre_signal import TyreBlock
from smart_tyre_forces.calibrate import raw_points
from smart_tyre_forces.calibration import Calibration, polynomial
from smart_tyre_forces.calibration_plots import quasi_static_maps
from smart_tyre_forces.correction import Patch, PatchCorrection
from smart_tyre_forces.fronts import LEVEL, find_fronts
from smart_tyre_forces.tooth_table import ToothTable

Array = NDArray[np.float64]

_SEED = 7
_ACCELERATION = (12.0, 22.0)
"""Part of the dynamic drive shown in Figure 8.24 [s]."""


CASE = "figures"
"""Of the rows that say what the figures show."""
_SPEEDS = (8.0, 22.0)
"""Between these the dynamic drive changes [m/s]."""


@dataclass(frozen=True)
class Shown:
    """A dynamic drive of one wheel."""

    patches: list[Patch]
    """Valid ones."""
    estimated: Estimated


def draw(directory: Path, runs: CalibrationRuns) -> list[Row]:
    """Write all figures as PNG files into `directory`, calibrated with `runs`; return what they show as rows."""
    directory.mkdir(parents=True, exist_ok=True)
    known = runs.calibrate()
    tables = {axle: ToothTable(np.asarray(wheel.tooth_table)) for axle, wheel in known.wheels.items()}
    block = simulate(dynamic_drive(road_seed=_SEED), "front", _SEED)
    _raw_signal(block, directory / "figure_8_16.png")
    _encoder(block, tables["front"], directory / "figure_8_18.png")
    _fronts(block, tables["front"], directory / "figure_8_19.png")
    points = {f"{r.wheel.name}, run {k}": raw_points(r, CAR, TRACKER) for k, r in enumerate(runs.quasi_static)}
    quasi_static_maps(points, known.tyre, directory / "figure_8_21.png")
    drives = {
        (axle, pressure): _drive(axle, known, tables[axle], pressure)
        for axle in ("rear", "front")
        for pressure in (NOMINAL, LOW)
    }
    rear, front = (drives[axle, NOMINAL].patches for axle in ("rear", "front"))
    _experiment(rear, _raw, "rear wheel, as measured", directory / "figure_8_20.png")
    for number, found, name in ((22, rear, "rear"), (23, front, "front")):
        title = f"{name} wheel, speed trend removed"
        _experiment(found, lambda p: _detrended(p, known), title, directory / f"figure_8_{number}.png", known)
    _cross_talk(front, known, directory / "figure_8_24.png")
    for number, axle, pressure in (
        (25, "rear", NOMINAL),
        (26, "front", NOMINAL),
        (27, "rear", LOW),
        (28, "front", LOW),
    ):
        found = drives[axle, pressure].patches
        title = f"{axle} wheel, {pressure / 1e5:.1f} bar, all corrections"
        _experiment(found, _final, title, directory / f"figure_8_{number}.png", known)
    _forces({axle: drives[axle, NOMINAL].estimated for axle in ("front", "rear")}, directory / "figure_forces.png")
    return [*_rows_of_signal(block, known), *_rows_of_phases(drives, known)]


def _drive(axle: str, known: Calibration, table: ToothTable, pressure: float) -> Shown:
    drive = dynamic_drive(road_seed=_SEED)
    found = passages(simulate(drive, axle, _SEED, SENSORS, pressure), table)
    correction = PatchCorrection(known.tyre, WHEEL.radius, TRACKER.sample_rate)
    patches = [correction.update(passage) for passage in found]
    return Shown([p for p in patches if p.reason is Reason.OK], estimate(found, known, drive, axle))


def _row(axle: str, quantity: str, value: float) -> Row:
    return {"case": CASE, "axle": axle, "quantity": quantity, **not_judged(value)}


def _rows_of_signal(block: TyreBlock, known: Calibration) -> list[Row]:
    """Twin spikes a revolution, the level between them, and the time of a revolution."""
    revolutions = float(block.wheel_angle[-1] - block.wheel_angle[0]) / (2.0 * np.pi)
    table = ToothTable(np.asarray(known.wheels["front"].tooth_table))
    rows = [_row("front", "twin spikes a revolution", len(passages(block, table)) / revolutions)]
    levels, centripetal = [], []
    for phase in ("low speed", "cruise"):
        begin, end = (round(time * TRACKER.sample_rate) for time in PHASES[phase])
        levels.append(float(np.median(block.radial_acceleration[begin:end])))
        turned = float(block.wheel_angle[end] - block.wheel_angle[begin])
        centripetal.append((turned * TRACKER.sample_rate / (end - begin)) ** 2 * RING.radius)
    # The rise, as the sensor has an offset.
    rise = (levels[1] - levels[0]) / (centripetal[1] - centripetal[0])
    rows.append(_row("front", "rise of the level from 8 to 22 m/s over that of omega^2 R", rise))
    rows.append(_row("front", "time of a revolution at 8 m/s [ms]", 1e3 * 2.0 * np.pi * RING.radius / _SPEEDS[0]))
    return rows


def _rows_of_phases(drives: Mapping[tuple[str, float], Shown], known: Calibration) -> list[Row]:
    rows = []
    for name, trend in (("shift", known.tyre.shift_trend), ("length", known.tyre.length_trend)):
        low, high = (np.degrees(polynomial(trend, speed)) for speed in _SPEEDS)
        rows.append(_row("both", f"trend of the {name}, 8 to 22 m/s [deg]", float(high - low)))
    rows.append(_row("both", "beta", known.tyre.beta))
    selections: dict[str, Callable[[list[Patch]], tuple[Array, Array]]] = {
        "raw": _raw,
        "without speed trend": lambda patches: _detrended(patches, known),
        "corrected": _final,
    }
    for (axle, pressure), shown in drives.items():
        time = _time(shown.patches)
        for stage, select in selections.items():
            for name, values in zip(("shift", "length"), select(shown.patches), strict=True):
                for phase, mean in means(time, np.degrees(values)).items():
                    rows.append(_row(axle, f"{pressure / 1e5:.1f} bar, {stage}: {name}, {phase} [deg]", mean))
    return rows


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
    _finish(figure, [axis], [("wheel angle [deg]", "acceleration over its fall in the patch [-]")], file)


def _experiment(
    patches: list[Patch],
    select: Callable[[list[Patch]], tuple[Array, Array]],
    title: str,
    file: Path,
    known: Calibration | None = None,
) -> None:
    """Draw speed, shift and length; with `known` the values they should have at constant speed."""
    shift, length = select(patches)
    time, speed = _time(patches), np.array([p.speed for p in patches])
    figure, axes = plt.subplots(3, 1, figsize=(8.0, 8.0), sharex=True)
    for axis, values in zip(axes, (speed, np.degrees(shift), np.degrees(length)), strict=True):
        axis.plot(time, values, linewidth=0.8)
    _shade(axes)
    if known is not None:
        axes[1].axhline(0.0, color="k", linestyle="--", linewidth=0.8)
        axes[2].axhline(np.degrees(known.tyre.nominal_length), color="k", linestyle="--", linewidth=0.8)
    axes[0].set_title(title)
    labels = [("", "wheel speed [m/s]"), ("", "phase shift [deg]"), ("time [s]", "patch length [deg]")]
    _finish(figure, list(axes), labels, file)


def _shade(axes: NDArray[np.object_]) -> None:
    """Mark acceleration and braking, and name the phases."""
    axes[0].margins(y=0.2)  # for the names
    for phase, (begin, end) in PHASES.items():
        if phase not in STEADY:
            for axis in axes:
                axis.axvspan(begin - 0.8, end + 0.4, color="0.9", zorder=0)
        axes[0].text(
            0.5 * (begin + end),
            0.98,
            phase,
            transform=axes[0].get_xaxis_transform(),
            ha="center",
            va="top",
            fontsize="small",
        )


def _forces(estimated: Mapping[str, Estimated], file: Path) -> None:
    figure, axes = plt.subplots(4, 1, figsize=(8.0, 10.0), sharex=True)
    labels = []
    for k, (axle, found) in enumerate(estimated.items()):
        for axis, name, values, truth in (
            (axes[2 * k], "Fx", found.fx, found.fx_true),
            (axes[2 * k + 1], "Fz", found.fz, found.fz_true),
        ):
            axis.plot(found.time, values / 1e3, linewidth=0.8, label="estimated")
            axis.plot(found.time, truth / 1e3, "k--", linewidth=0.6, label="true")
            labels.append(("time [s]" if axis is axes[-1] else "", f"{name}, {axle} [kN]"))
    _shade(axes)
    axes[0].legend(loc="lower left")
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
