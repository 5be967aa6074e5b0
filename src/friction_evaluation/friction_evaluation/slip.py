"""Vehicle speed and slip without a speed sensor: simulated stops with the supervisor, and the measured one.

The estimator is wheel_slip with its shipped parameters; what differs between the cars are their vehicle files:
compact_car (or --vehicle) for the stops, bmw_m8 for the measured one. The baseline `best_wheel` takes the fastest wheel
for the car. Errors count from brake onset down to 3 m/s, over every sample and wheel, valid or not.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from friction_bags.importers.bmw import COLUMNS, STAMP_OFFSET, messages
from friction_bags.importers.bmw import WHEELS as BMW_WHEELS
from friction_bags.importers.import_csv import read_rows
from friction_evaluation.measured import BMW, BMW_M8, data_directory
from friction_evaluation.parts import Row
from friction_evaluation.slip_stops import CAR, END_SPEED, STEP, Stop, cruise_torque, stops
from friction_evaluation.slip_tables import tables
from friction_parameters.parameter import ParameterError
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.two_axle import four_wheels
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import SHIPPED, WheelSlipParameters
from wheel_slip.processor import VEHICLE_VELOCITY, CarProcessor

Array = NDArray[np.float64]

ROADS = ("dry", "wet", "snow")
LIMITS = {"dry": (0.08, 0.009), "wet": (0.085, 0.010), "snow": (0.13, 0.006), "bmw": (0.05, 0.006)}
"""Speed [m/s] and slip [-] RMS error asked for."""
BMW_STOP = (6.9, 9.0)
"""The stop in the file's time [s]."""
INJECTED_OFFSET = 0.35
"""[m/s^2]"""
GRADE_STEP = 0.02
CASES = ("stops", "measured", "tables")
"""Simulated stops, the BMW stop, Tables 8.4 and 8.5."""
_FIRST_SEED = 30_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=int, default=100, help="noise seeds a road")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES, help="what to run")
    parser.add_argument(
        "--vehicle", default="compact_car", help="car of the stops: vehicle file or name of a shipped one"
    )
    parser.add_argument("--data", type=Path, default=data_directory(), help="directory of the measured data")


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs. Of the stops and the BMW, two rows a case: the estimator's and the baseline's."""
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
    rows: list[Row] = []
    if "stops" in options.cases:
        rows += _simulated(seeds, _car_of_stops(options.vehicle))
    if "measured" in options.cases:
        rows += _measured(options.data / BMW)
    if "tables" in options.cases:
        rows += tables(seeds, shipped())
    return rows


def _car_of_stops(name: str) -> Vehicle:
    vehicle = load_vehicle(name)
    try:
        four_wheels(vehicle)
        cruise_torque(vehicle, np.zeros(1))
    except ValueError as error:
        raise ParameterError(f"--vehicle {name}: {error}") from error
    return vehicle


def _simulated(seeds: range, vehicle: Vehicle) -> list[Row]:
    rows: list[Row] = []
    with Progress() as progress:
        task = progress.add_task("stops", total=(len(ROADS) + 1) * 2 * len(seeds))

        def advance(done: int) -> None:
            progress.advance(task, done)

        def followed(road: str, grade_step: float) -> list[Followed]:
            made = stops(road, seeds, grade_step=grade_step, vehicle=vehicle, progress=advance)
            return [follow(stop, vehicle, advance) for stop in made]

        for road in ROADS:
            rows += _rows(road, followed(road, 0.0))
        stepped = followed("dry", GRADE_STEP)
    return rows + _rows("dry with a slope step of 2 % in mid-stop", stepped)


def _measured(path: Path) -> list[Row]:
    if not path.is_file():
        print(f"case bmw left out, measured data are absent: {path} (give --data, or set FRICTION_DATA)")
        return []
    shifted = _rows("bmw, accelerometer +0.35 m/s^2", [follow_bmw(path, INJECTED_OFFSET)])
    return _rows("bmw", [follow_bmw(path)]) + shifted


@dataclass(frozen=True)
class Followed:
    """Errors of one run, n samples from brake onset to the end speed."""

    speed: Array
    """Of the speed [m/s], shape (n,)."""
    deviation: Array
    """Standard deviation the estimator gives for it [m/s], shape (n,)."""
    slip: Array
    """Of the slip [-], shape (n, wheels)."""
    valid: float
    """Share of valid slips."""
    best_wheel_speed: Array
    """Of the baseline [m/s], shape (n,)."""
    best_wheel_slip: Array
    """Of the baseline [-], shape (n, wheels)."""


def shipped() -> WheelSlipParameters:
    """Return the shipped parameters."""
    parameters: WheelSlipParameters = SHIPPED["wheel_slip"].parameters
    return parameters


def follow(stop: Stop, vehicle: Vehicle = CAR, advance: Callable[[int], None] = lambda _done: None) -> Followed:
    """One stop of a car through the estimator; `advance` is told that it has ended."""
    wheels_of_car = four_wheels(vehicle)
    estimator = SlipEstimator(replace(vehicle, wheels=wheels_of_car), shipped().estimator)
    found: list[tuple[float, float]] = []
    wheels: list[list[float]] = []
    valid = 0
    for k, (measured, acceleration) in enumerate(zip(stop.wheel_speed, stop.acceleration, strict=True)):
        estimates = estimator.update((k + 1) * STEP, measured.tolist(), float(acceleration))
        if k >= stop.onset:
            found.append((estimates[0].vehicle_speed, estimates[0].vehicle_speed_variance))
            wheels.append([estimate.wheel_speed for estimate in estimates])
            valid += sum(not estimate.reason for estimate in estimates)
    advance(1)
    braked = slice(stop.onset, None)
    radii = np.array([wheel.radius for wheel in wheels_of_car])
    return _compare(
        np.array(found), np.array(wheels), stop.wheel_speed[braked], radii, stop.speed[braked], stop.slip[braked], valid
    )


def follow_bmw(path: Path, offset: float = 0.0) -> Followed:
    """The measured stop through the wheel processor, the reference speed withheld; slip is judged against it."""
    processor = CarProcessor(BMW_M8, shipped())
    found: list[tuple[float, float]] = []
    wheels: list[list[float]] = []
    measured: list[list[float]] = []
    truth: list[float] = []
    valid = 0
    for row in read_rows(path, COLUMNS):
        outputs = []
        for topic, message in messages([row]):
            name = topic.lstrip("/")
            if name == "imu/data":
                message.linear_acceleration.x += offset
            if name in processor.sensors and name != VEHICLE_VELOCITY:
                outputs += [answer for _, answer in processor.process(name, message)]
        inside = BMW_STOP[0] <= row["t_s"] <= BMW_STOP[1] and row["vx_mps"] > END_SPEED
        if inside and outputs and to_nanoseconds(outputs[0].header.stamp) == _stamp(row["t_s"]):
            found.append((outputs[0].vehicle_speed, outputs[0].vehicle_speed_variance))
            wheels.append([output.wheel_speed for output in outputs])
            measured.append([row[column] for column in BMW_WHEELS.values()])
            truth.append(row["vx_mps"])
            valid += sum(output.valid for output in outputs)
    speed, radii = np.array(truth), np.array(BMW_M8.radii)
    slip = 1.0 - np.array(measured) * radii / speed[:, np.newaxis]
    return _compare(np.array(found), np.array(wheels), np.array(measured), radii, speed, slip, valid)


def _stamp(seconds: float) -> int:
    return round(seconds * 1e9) + STAMP_OFFSET * 1_000_000_000


def _compare(
    found: Array, wheels: Array, measured: Array, radii: Array, speed: Array, slip: Array, valid: int
) -> Followed:
    best = (measured * radii).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where every wheel stands the baseline has no slip; it counts as none at all.
        best_slip = np.where(best[:, np.newaxis] > 0.0, 1.0 - measured * radii / best[:, np.newaxis], 0.0)
    return Followed(
        speed=found[:, 0] - speed,
        deviation=np.sqrt(found[:, 1]),
        slip=1.0 - wheels * radii / found[:, :1] - slip,
        valid=valid / slip.size,
        best_wheel_speed=best - speed,
        best_wheel_slip=best_slip - slip,
    )


def _rows(case: str, runs: Sequence[Followed]) -> list[Row]:
    limits = LIMITS.get(case.split(",")[0], (float("nan"), float("nan")))
    within = np.concatenate([np.abs(run.speed) <= 2.0 * run.deviation for run in runs])
    return [
        {
            "case": case,
            "method": "wheel_slip",
            "speed_rms": _rms([run.speed for run in runs]),
            "slip_rms": _rms([run.slip for run in runs]),
            "runs": len(runs),
            "speed_rms_limit": limits[0],
            "slip_rms_limit": limits[1],
            "worst_run_speed_rms": max(_rms([run.speed]) for run in runs),
            "valid": float(np.mean([run.valid for run in runs])),
            "within_2_sigma": float(within.mean()),
            "sigma_at_onset": float(np.mean([run.deviation[0] for run in runs])),
            "sigma_at_end": float(np.mean([run.deviation[-1] for run in runs])),
        },
        {
            "case": case,
            "method": "best_wheel",
            "speed_rms": _rms([run.best_wheel_speed for run in runs]),
            "slip_rms": _rms([run.best_wheel_slip for run in runs]),
            "runs": len(runs),
        },
    ]


def _rms(errors: Sequence[Array]) -> float:
    """Root of the mean square over all samples of all runs."""
    return sqrt(float(np.mean(np.concatenate([error.ravel() for error in errors]) ** 2)))
