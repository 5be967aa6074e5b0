"""Section 8.2: Figures 8.1 to 8.4 on the driver's stops, mean slip at detection as shipped and as printed.

As printed are (8.4) and (8.5): H times the sign of the slip rate or of eta, one negative threshold, no dead zones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from friction_msgs.msg import WheelSlip
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.protocol import ACCELERATION_STDDEV, BRAKE_GAIN, CAR, CORNER
from benchmarks.runner import Row, rows_of
from benchmarks.slope.detection import METHODS, Run, detect, sensor_messages, shipped_settings, through_the_peak
from book import state_machine_figure
from book.chapter_numbers import SLIP_AT_DETECTION, compared, spread
from book.driver_stop import ROADS, StopRun, stop_run
from book.page import Picture, Section, Table
from corner_sim.sensors import CHAPTER_NOISE
from friction_runtime.messages import to_nanoseconds
from friction_slope.estimate import SlopeSample
from friction_slope.signals import SignalWindow
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]

EQUATIONS = {"slip": "(8.4)", "no_slip": "(8.5)"}


@dataclass(frozen=True)
class Printed:
    """What the chapter leaves to tuning."""

    window: int
    """Samples of the fits that give H, slip rate and eta; the slip is read at its centre, too."""
    least_torque: float
    """T-bar: nothing is detected below this brake torque [N m]."""
    h_instability: float = -15.0
    """[rad/s^3]"""


VARIANTS = (Printed(28, 100.0), Printed(28, 30.0), Printed(16, 100.0))
"""The quietest window that keeps up with the manoeuvre, with a threshold of torque above the noise of H and with one at
the onset; and a window in whose noise H falls below the threshold before the peak."""


def slips_at_detection(run: Run, variants: Sequence[Printed], slip: WheelSlipParameters, seed: int) -> Array:
    """Slip at the first detection [-] by each variant and method, shape (variants, 2); NaN where there is none."""
    samples = _samples(run, slip, seed)
    found = np.full((len(variants), len(METHODS)), np.nan)
    for row, variant in zip(found, variants, strict=True):
        window = SignalWindow(CORNER.inertia, variant.window, variant.window, 0.0)
        for sample in samples:
            window.update(sample, sample.slip)
            if not window.ready or sample.brake_torque < variant.least_torque:
                continue
            growing = np.sign([window.slip_rate(), -window.wheel_acceleration()])
            detected = np.isnan(row) & (growing * window.h() <= variant.h_instability)
            row[detected] = window.slip()
    return found


def _samples(run: Run, parameters: WheelSlipParameters, seed: int) -> list[SlopeSample]:
    """Measured wheel speed and torque, with slip and slip rate by the shipped wheel_slip."""
    car = CarProcessor(CAR, parameters)
    samples = []
    for messages in sensor_messages(run, CHAPTER_NOISE, ACCELERATION_STDDEV, seed):
        inputs: dict[str, Any] = dict(messages)
        (torque,) = (m.fluid_pressure * BRAKE_GAIN for t, m in messages if t.endswith("brake_pressure"))
        answers = [a for t, m in messages if t in car.sensors for _, a in car.process(t, m)]
        (estimate,) = (answer for answer in answers if isinstance(answer, WheelSlip))
        wheel = inputs["wheel_states"]
        stamp = to_nanoseconds(wheel.header.stamp)
        samples.append(SlopeSample(stamp, wheel.velocity[0], torque, estimate.slip, estimate.slip_rate))
    return samples


PRINTED = {
    f"printed: {v.window} samples, T_b above {v.least_torque:.0f} N m": variant for variant, v in enumerate(VARIANTS)
}
"""Columns of the table, and the variant of each."""
_FIRST_SEED = 40_000
_SEEDS = 200
"""For each road."""
_SHOWN = (0.4, 2.2)
"""Time of a stop in the figures [s]."""
_TEXT = """The figures show a driver's stop of a car with load transfer, springs and tyres that relax. The first table
is of one corner whose torque is built up in 0.25 s, held until twice lambda_max and released: as friction_slope is
shipped, and by the equations as printed, with one negative threshold. Early: detected before the peak."""


def section(directory: Path, seeds: Callable[[int], int]) -> Section:
    """Make the runs and draw into `directory`."""
    rows, numbers = mean_slips(seeds(_SEEDS))
    detected, closed = (
        rows_of("benchmarks", part, "--seeds", str(seeds(full))) for part, full in (("slope", 300), ("abs", 100))
    )
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
    machine = directory / "figure_8_1.png"
    state_machine_figure.draw(machine)
    pictures.append(Picture("Figure 8.1: states and transitions, found by trying every class of input", machine))
    tables = [
        Table("Section 8.2.3: mean slip at the first detection, and ratio of the runs in which it came early", rows),
        Table("One corner through the peak and back: delay, false alarms, slip at detection", detected, folded=True),
        Table("Closed loop from 30 to 5 m/s", closed, folded=True),
    ]
    return Section("8.2", "Slope sign, Figures 8.1 to 8.4", _TEXT, tables, pictures, numbers)


def mean_slips(seeds: int) -> tuple[list[Row], list[Row]]:
    """Rows by road and equation of the mean slip at the first detection, and the chapter's numbers beside ours."""
    settings = shipped_settings(imu=True)
    rows: list[Row] = []
    numbers: list[Row] = []
    for road in ("high_grip", "off_road"):
        run = through_the_peak(road)
        of_seeds = range(_FIRST_SEED, _FIRST_SEED + seeds)
        shipped = [detect(run, settings, CHAPTER_NOISE, seed) for seed in of_seeds]
        printed = np.array([slips_at_detection(run, VARIANTS, settings.slip, seed) for seed in of_seeds])
        for column, method in enumerate(METHODS):
            ours = np.array([found[method].slip for found in shipped])
            lost = np.array([found[method].lost for found in shipped])
            chapter = SLIP_AT_DETECTION[road, EQUATIONS[method]]
            what = f"slip at detection by {EQUATIONS[method]}, {road}"
            numbers.append(compared("8.2.3", what, chapter, spread(ours.tolist())))
            row: Row = {
                "road": road,
                "equation": EQUATIONS[method],
                "runs": seeds,
                "lambda_max": run.lambda_max,
                "chapter": chapter,
                "shipped": float(np.nanmean(ours)),
                "shipped: early [%]": 100.0 * float(np.mean(lost < run.crossings()[0])),
                "shipped: missed [%]": 100.0 * float(np.mean(np.isnan(lost))),
            }
            for name, variant in PRINTED.items():
                slips = printed[:, variant, column]
                row[name] = float(np.nanmean(slips))
                row[f"{name}: early [%]"] = 100.0 * float(np.mean(slips < run.lambda_max))
            rows.append(row)
    return rows, numbers


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
