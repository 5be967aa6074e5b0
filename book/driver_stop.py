"""One of the driver's stops of section 8.2.3 through the shipped wheel_slip and friction_slope, and Figure 8.9.

The car has load transfer, springs and tyres that relax. So its friction samples overshoot the static curve: the load of
a front wheel swings beyond its steady value, and friction follows the slip with a lag. As in the chapter, the
theoretical curve of Figure 8.9 holds the steady load transfer, and the samples are made with the static load.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from friction_msgs.msg import FrictionSlope, WheelSlip
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.runner import Row, as_text
from benchmarks.slope.detection import METHODS, shipped_settings
from benchmarks.slope.driver_stops import StopTruth, true_stop
from book.page import Picture, Table
from corner_sim.plant import SAMPLE_TIME, SAMPLE_TIME_NS, PlantSample
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Sensors
from friction_bags.experiments.stops import ACCELERATION_VARIANCE, STOPS, car_of_the_stops
from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource
from friction_curve_id.interface import Sample
from vehicle_models import burckhardt
from vehicle_models.wheel_forces import WheelLoad

Array = NDArray[np.float64]

ROADS = dict(zip(("high grip", "low grip"), STOPS, strict=True))
"""Stops by the roads of the chapter."""
VEHICLE = car_of_the_stops()
WHEEL = "front_left"
CORNER = VEHICLE.corner(WHEEL)


@dataclass(frozen=True)
class StopRun:
    """The front left wheel; arrays of shape (samples,), or (samples, methods) of the signs."""

    truth: StopTruth
    onset: int
    """First sample with brake torque."""
    end: int
    """Sample of the largest slip, where the release acts."""
    speed: Array
    """True [m/s]: what an optical sensor measures."""
    slip: Array
    """True [-]."""
    estimated_slip: Array
    """By wheel_slip, without a speed sensor [-]."""
    wheel_speed: Array
    """Measured [rad/s]."""
    torque: Array
    """Measured [N m]."""
    load: Array
    """Vertical load from the measured acceleration [N]."""
    signs: Array
    """Published by friction_slope, in the order of METHODS; 0 where not known."""

    def history(self, signal: str) -> Array:
        """One of the plant's signals of this wheel, by its name in PlantSample."""
        return np.array([getattr(sample, signal)[0] for sample in self.truth.samples])

    def friction_samples(self, estimated: bool, moving_load: bool) -> list[tuple[int, FrictionPoint]]:
        """Friction samples by the wheel equation, each with its number, up to the largest slip.

        Args:
            estimated: take the speed that follows from the slip of wheel_slip, not the true one.
            moving_load: divide by the load from the acceleration, not by that at rest.
        """
        maker = FrictionSamples(CORNER, FrictionSource.WHEEL_EQUATION)
        found = []
        for k in range(self.end):
            reckoned = float(self.wheel_speed[k] * CORNER.radius / (1.0 - self.estimated_slip[k]))
            speed = reckoned if estimated else float(self.speed[k])
            torque = max(float(self.torque[k]), 0.0)
            point = maker.update(Sample((k + 1) * SAMPLE_TIME, float(self.wheel_speed[k]), speed, torque))
            if isinstance(point, FrictionPoint):
                share = CORNER.vertical_load / float(self.load[k]) if moving_load else 1.0
                found.append((k, point._replace(mu=point.mu * share)))
        return found


@cache
def stop_run(name: str, seed: int) -> StopRun:
    """Make a stop of STOPS with the chapter's noise."""
    truth = true_stop(name, VEHICLE.pitch_frequency)
    sensors = Sensors(CHAPTER_NOISE, ACCELERATION_VARIANCE, 0.0, VEHICLE, seed)
    car, slopes = shipped_settings(imu=True).processors(VEHICLE, WHEEL)
    load = WheelLoad(VEHICLE, WHEEL)
    kept, signs = [], np.zeros((len(truth.samples), len(METHODS)))
    for k, sample in enumerate(truth.samples):
        stamp = (k + 1) * SAMPLE_TIME_NS
        measured = sensors.measure(sample)
        slip = np.nan
        load.update(stamp, measured.acceleration)
        for topic, message in messages.sensors(stamp, VEHICLE, measured, CHAPTER_NOISE, ACCELERATION_VARIANCE):
            inputs: list[tuple[str, Any]] = [(topic, message)]
            inputs += car.process(topic, message) if topic in car.sensors else []
            slip = next((m.slip for t, m in inputs if isinstance(m, WheelSlip) and t == f"{WHEEL}/slip"), slip)
            for column, method in enumerate(METHODS):
                slope = slopes[method]
                for name_of, given in inputs:
                    if name_of in slope.sensors or name_of in slope.estimates:
                        for _, answer in slope.process(name_of, given):
                            if isinstance(answer, FrictionSlope):
                                signs[_index(answer), column] = answer.sign
        torque = measured.brake_pressure[0] * VEHICLE.wheel(WHEEL).brake_gain
        kept.append((sample.speed, slip, measured.wheel_speed[0], torque, load.load))
    speed, estimated, wheel_speed, torques, loads = np.array(kept).T
    slips = np.array([sample.slip[0] for sample in truth.samples])
    onset = _first(truth.samples)
    return StopRun(truth, onset, int(np.argmax(slips)), speed, slips, estimated, wheel_speed, torques, loads, signs)


def _first(samples: tuple[PlantSample, ...]) -> int:
    return int(np.argmax(np.array([sample.brake_torque[0] for sample in samples]) > 0.0))


def _index(answer: FrictionSlope) -> int:
    stamp = answer.header.stamp
    return int((stamp.sec * 1_000_000_000 + stamp.nanosec) // SAMPLE_TIME_NS - 1)


_TRANSFER = VEHICLE.height_ratio / VEHICLE.front_load_share
"""The load of a front wheel grows by this share for a deceleration of g [-]."""
_SEED = 40_000


def figure_8_9(directory: Path) -> tuple[Table, Picture]:
    """Draw Figure 8.9 into `directory`."""
    rows = abscissas()
    run = stop_run(ROADS["high grip"], _SEED)
    file = directory / "figure_8_9.png"
    _draw_samples(run, file)
    high = rows[0]
    excess, moved = (as_text(high[name]) for name in ("overshoot [%]", "abscissa moved, load at rest [%]"))
    caption = f"""Figure 8.9: friction samples of the front left wheel on the high-grip road. Made with the load at rest
    (dots) they exceed the theoretical curve by {excess} % and are highest {moved} % beyond lambda_max; made with the
    load from the acceleration (circles) they follow the curve without load transfer"""
    table = Table("Figure 8.9: highest friction of the two stops, without noise", rows)
    return table, Picture(" ".join(caption.split()), file)


def abscissas() -> list[Row]:
    """Rows by road: largest excess over the curve at the same slip, and how far from lambda_max the highest is [%]."""
    rows: list[Row] = []
    for road, name in ROADS.items():
        run = stop_run(name, _SEED)
        slip, friction, load = (run.history(signal)[: run.end] for signal in ("slip", "friction", "vertical_load"))
        at_rest = friction * load / CORNER.vertical_load
        theta = run.truth.samples[0].theta[0]
        theory = with_steady_transfer(theta, slip)
        beyond = slip > 0.5 * run.truth.lambda_max
        moved = [100.0 * (float(slip[np.argmax(each)]) / run.truth.lambda_max - 1.0) for each in (at_rest, friction)]
        rows.append(
            {
                "road": road,
                "lambda_max": run.truth.lambda_max,
                "overshoot [%]": 100.0 * (float(np.max((at_rest / theory)[beyond])) - 1.0),
                "abscissa moved, load at rest [%]": moved[0],
                "abscissa moved, load as it is [%]": moved[1],
            }
        )
    return rows


def with_steady_transfer(theta: Array, slip: Array) -> Array:
    """Friction coefficient that the static load would show in steady braking [-], shape of `slip`."""
    static = burckhardt.friction(theta, slip)
    return np.asarray(static * (1.0 + _TRANSFER * static))


def _draw_samples(run: StopRun, file: Path) -> None:
    figure = Figure(figsize=(8.0, 4.8), layout="constrained")
    axes = figure.subplots()
    for moving, marker, label in ((False, ".", "load at rest"), (True, "o", "load from the acceleration")):
        points = run.friction_samples(estimated=True, moving_load=moving)
        braked = np.array([(point.slip, point.mu) for number, point in points if number >= run.onset])
        axes.plot(*braked.T, marker, markersize=4, fillstyle="none", label=f"samples, {label}")
    grid = np.linspace(0.0, float(run.slip.max()), 200, dtype=np.float64)
    theta = run.truth.samples[0].theta[0]
    axes.plot(grid, with_steady_transfer(theta, grid), "r--", label="theoretical, steady load transfer")
    axes.plot(grid, burckhardt.friction(theta, grid), "k:", label="theoretical, load at rest")
    axes.axvline(run.truth.lambda_max, color="k", linestyle="--", linewidth=0.8, label="lambda_max, true")
    axes.set(xlabel="slip [-]", ylabel="friction coefficient [-]", ylim=(-0.1, None))
    axes.legend(loc="lower right", fontsize="small")
    figure.savefig(file, dpi=110)
