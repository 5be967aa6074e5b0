"""Vehicle speed and slip without a speed sensor: stops, a measured stop, drives of random cars, curves, faults."""

import argparse
from collections.abc import Sequence
from math import sqrt
from pathlib import Path

import numpy as np
from rich.progress import Progress

from benchmarks.measured import BMW, IAC, data_directory
from benchmarks.runner import Row, at_most
from benchmarks.slip.accelerometer_faults import fault_rows
from benchmarks.slip.consistency import consistency_rows, laps_rows
from benchmarks.slip.curves import curve_rows
from benchmarks.slip.stops import (
    Array,
    Followed,
    cruising,
    follow,
    follow_bmw,
    shipped,
    stops,
)
from friction_parameters.command_line import count
from friction_parameters.parameter import ParameterError
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

ROADS = ("dry", "wet", "snow")
LIMITS = {"dry": (0.08, 0.009), "wet": (0.085, 0.010), "snow": (0.13, 0.006), "bmw": (0.05, 0.006)}
"""Largest RMS errors of speed [m/s] and slip [-] that are accepted, of the stops with the default car."""
_CAR_OF_STOPS = "compact_car"
INJECTED_OFFSET = 0.35
"""[m/s^2]"""
GRADE_STEP = 0.02
CASES = ("stops", "measured", "drives", "curves", "faults")
"""Simulated stops, the BMW stop; drives, stops in curves and faults of the accelerometer of a car that is known only by
its vehicle file."""
_FIRST_SEED = 30_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=100, help="noise seeds a road")
    parser.add_argument("--cars", type=count, default=8, help="cars drawn for each of the drives")
    parser.add_argument("--first-car", type=count, default=1, help="number of the first of them")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES, help="what to run")
    parser.add_argument(
        "--vehicle", default=_CAR_OF_STOPS, help="car of the stops: vehicle file or name of a shipped one"
    )
    parser.add_argument("--data", type=Path, default=data_directory(), help="directory of the measured data")


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs; return the rows.

    A case of the stops or the BMW has a row of the estimator and one of the baseline, and where it has limits one for
    each of them.
    """
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
    cars = range(options.first_car - 1, options.first_car - 1 + options.cars)
    rows: list[Row] = []
    if "stops" in options.cases:
        stopped = _simulated(seeds, _car_of_stops(options.vehicle))
        rows += stopped + (_judged(stopped) if options.vehicle == _CAR_OF_STOPS else [])
    if "measured" in options.cases:
        measured = _measured(options.data / BMW)
        rows += measured + _judged(measured)
        rows += _laps(options.data / IAC)
    if "drives" in options.cases:
        rows += consistency_rows(_car_of_stops(options.vehicle), shipped().estimator, cars)
    if "curves" in options.cases:
        rows += curve_rows(_car_of_stops(options.vehicle), shipped().estimator, cars)
    if "faults" in options.cases:
        rows += fault_rows(_car_of_stops(options.vehicle), shipped().estimator, cars)
    return rows


def _car_of_stops(name: str) -> Vehicle:
    vehicle = load_vehicle(name)
    try:
        cruising(vehicle)
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


def _laps(path: Path) -> list[Row]:
    if not path.is_file():
        print(f"laps left out, measured data are absent: {path} (give --data, or set FRICTION_DATA)")
        return []
    return laps_rows(path)


def _rows(case: str, runs: Sequence[Followed]) -> list[Row]:
    within = np.concatenate([np.abs(run.speed) <= 2.0 * run.deviation for run in runs])
    return [
        {
            "case": case,
            "method": "wheel_slip",
            "speed_rms": _rms([run.speed for run in runs]),
            "slip_rms": _rms([run.slip for run in runs]),
            "runs": len(runs),
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


def _judged(rows: Sequence[Row]) -> list[Row]:
    """What has to hold of the rows of cases that have limits."""
    found: list[Row] = []
    for row in rows:
        limits = LIMITS.get(row["case"].split(",")[0])
        if limits is not None and row["method"] == "wheel_slip":
            for quantity, limit in zip(("speed_rms", "slip_rms"), limits, strict=True):
                found.append({"case": row["case"], "quantity": quantity, **at_most(row[quantity], limit)})
    return found


def _rms(errors: Sequence[Array]) -> float:
    """Root of the mean square over all samples of all runs."""
    return sqrt(float(np.mean(np.concatenate([error.ravel() for error in errors]) ** 2)))
