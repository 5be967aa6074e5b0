"""Closed loop with the supervisor: stops from 30 to 5 m/s by the chapter's law, or to standstill with --law."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from abs_supervisor.parameters import CURVE, SLOPE_SIGN
from benchmarks.abs.controllers import THRESHOLDS, BrakedCorners, Parameters, processors, shipped
from benchmarks.abs.law_rows import CARS, CORNER_ALONE, law_rows
from benchmarks.abs.panic_stop import END_SPEED, LOCK_TIME, LONGEST, LongestLock
from benchmarks.protocol import CAR, DT, SPEED, VEHICLE
from benchmarks.runner import Row, at_least, at_most
from friction_parameters.command_line import count
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

_ROLLING = 60
"""Samples of free rolling before the brake: 0.3 s."""
_BUILD_UP = 0.4
"""Time after the onset left out of the second utilisation [s]."""


@dataclass
class Stops:
    """Results of n stops, arrays of shape (n,)."""

    utilisation: Array
    """[-]"""
    utilisation_late: Array
    """[-] without the first 0.4 s."""
    distance: Array
    """[m] from brake onset to the end speed."""
    duration: Array
    """[s]"""
    longest_lock: Array
    """[s] longest time with a slip above 0.95."""
    transitions: Array
    release_timeouts: Array
    fail_safes: Array


def stops(
    name: str,
    seeds: range,
    parameters: Parameters,
    done: Callable[[int], None] = lambda count: None,
    vehicle: Vehicle = CAR,
) -> Stops:
    """Brake once for each seed, side by side: the plant is one array, each run has its own processors.

    Args:
        name: of the surface.
        seeds: of the sensor noise.
        parameters: of friction_slope and abs_supervisor.
        done: called with the number of runs that have just ended.
        vehicle: its first wheel brakes, with the mass that rests on it.
    """
    count = len(seeds)
    braked = BrakedCorners(name, seeds, partial(processors, parameters=parameters), vehicle=vehicle)
    plant = braked.plant
    corner = plant.corner
    lock = LongestLock(count)
    used, late = np.zeros(count), np.zeros(count)
    result = Stops(*(np.zeros(count) for _ in range(8)))
    running = np.ones(count, dtype=bool)
    braked.roll(_ROLLING)
    start = corner.distance
    while running.any() and plant.since < LONGEST:
        since = plant.since
        braked.brake(running)
        ratio = np.where(running, corner.friction(plant.theta) / plant.mu_max, 0.0)
        used += ratio
        late += ratio * (since > _BUILD_UP - 0.5 * DT)
        result.duration += DT * running
        lock.update(corner.slip, running)
        ended = running & (corner.speed <= END_SPEED)
        result.distance = np.where(ended, corner.distance - start, result.distance)
        running &= ~ended
        done(int(ended.sum()))
    result.longest_lock = lock.longest
    result.utilisation = used * DT / result.duration
    result.utilisation_late = late * DT / np.maximum(result.duration - _BUILD_UP, DT)
    for i, controller in enumerate(braked.controllers):
        values = controller.processors[-1].health().values
        result.transitions[i] = float(values["transitions"])
        result.release_timeouts[i] = float(values["release time-outs"])
        result.fail_safes[i] = float(values["fail-safes"])
    return result


_UTILISATION = {"dry": 0.92, "wet": 0.93, "cobblestone": 0.88, "snow": 0.93}
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
    return law_rows(cars, options.law, options.seeds, surfaces, cases, options.law == CURVE)


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
