"""Closed loop from 30 to 5 m/s: plant, shipped friction_slope (no_slip) and abs_supervisor, chapter noise.

The plant is one corner of a car: the chapter's, or the first wheel of --vehicle. The driver's demand is a step to 1.5
times the peak torque. Utilisation is the mean of mu / mu_max from the brake onset to 5 m/s; the ideal stop holds mu_max
all the way. A lock is a slip above 0.95 for 50 ms.

With --law the rows are those of law_rows: to standstill, without speed sensor, beside the bound of the brake, of one
corner and of a car with four wheels whose loads follow the deceleration at once (four_wheels) or that has the troubles
of a real one (car). One corner also stops where the road changes, and the car where it differs from side to side
(split). With --car smart_tyres: what the forces of smart tyres say beside the loop.
"""

import argparse
from functools import partial

from rich.progress import Progress

from abs_supervisor.parameters import CURVE, SLOPE_SIGN
from benchmarks.closed_loop.controller import shipped
from benchmarks.closed_loop.law_rows import CARS, CORNER_ALONE, chosen, law_rows
from benchmarks.closed_loop.longest_lock import LOCK_TIME
from benchmarks.closed_loop.panic_stop import END_SPEED
from benchmarks.closed_loop.stops import Stops, stops
from benchmarks.closed_loop.threshold_abs import THRESHOLDS
from benchmarks.protocol import SPEED, VEHICLE
from benchmarks.rows import Row, at_least, at_most
from friction_parameters.command_line import count
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

_UTILISATION = {"dry": 0.798, "wet": 0.850, "cobblestone": 0.742, "snow": 0.777}
"""Smallest mean utilisation of the chapter's corner."""
_FIRST_SEED = 20_000
"""Far from the seeds of the tuning."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=100, help="noise seeds a surface")
    parser.add_argument(
        "--vehicle", default=VEHICLE, help="vehicle file or name of a shipped one: its first wheel brakes"
    )
    parser.add_argument(
        "--law", choices=(SLOPE_SIGN, CURVE, THRESHOLDS), help="instead: stops to standstill under this law"
    )
    parser.add_argument("--car", action="append", choices=CARS, default=[], help="only these cars; repeatable")
    for name in ("surface", "case"):
        parser.add_argument(f"--{name}", action="append", default=[], help="only these rows of --law; repeatable")


def run(options: argparse.Namespace) -> list[Row]:
    """Make all runs; return a row per surface, and with the chapter's corner what has to hold there."""
    if options.law:
        return _of_law(options)
    rows: list[Row] = []
    vehicle = load_vehicle(options.vehicle)
    with Progress() as progress:
        task = progress.add_task("closed loop", total=len(TABLE_8_1) * options.seeds)
        for name in TABLE_8_1:
            seeds = range(_FIRST_SEED, _FIRST_SEED + options.seeds)
            found = stops(name, seeds, shipped(), lambda n: progress.advance(task, n), vehicle)
            rows.append(_row(name, found, vehicle))
            if options.vehicle == VEHICLE:
                rows += _judged(name, found)
    return rows


def _of_law(options: argparse.Namespace) -> list[Row]:
    # The thresholds are those of one corner.
    cars = [CORNER_ALONE] if options.law == THRESHOLDS else options.car
    surfaces, cases = options.surface, options.case
    with Progress() as progress:
        judged = options.law == CURVE
        total = len(chosen(cars, options.law, options.seeds, surfaces, cases, judged))
        done = partial(progress.advance, progress.add_task(options.law, total=total))
        return law_rows(cars, options.law, options.seeds, surfaces, cases, judged, done)


def _judged(name: str, found: Stops) -> list[Row]:
    locked = int((found.longest_lock >= LOCK_TIME).sum())
    return [
        {"surface": name, "quantity": "utilisation", **at_least(float(found.utilisation.mean()), _UTILISATION[name])},
        {"surface": name, "quantity": "runs with lock", **at_most(locked, 0)},
    ]


def _row(name: str, found: Stops, vehicle: Vehicle) -> Row:
    gravity = vehicle.corner(vehicle.wheel_names[0]).gravity
    mu_max = float(burckhardt.peak(surface(name))[1])
    ideal = (SPEED**2 - END_SPEED**2) / (2.0 * mu_max * gravity)
    return {
        "surface": name,
        "method": "no_slip",
        "seeds": found.duration.size,
        "utilisation": float(found.utilisation.mean()),
        "utilisation_worst": float(found.utilisation.min()),
        "utilisation_without_0.4s": float(found.utilisation_late.mean()),
        "runs_with_lock": int((found.longest_lock >= LOCK_TIME).sum()),
        "longest_lock_ms": 1e3 * float(found.longest_lock.max()),
        "distance_m": float(found.distance.mean()),
        "ideal_distance_m": ideal,
        "distance_ratio": float(found.distance.mean()) / ideal,
        "transitions": float(found.transitions.mean()),
        "release_timeouts": float(found.release_timeouts.mean()),
        "fail_safes": int(found.fail_safes.sum()),
    }
