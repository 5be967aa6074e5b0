"""Cost per sample of every estimator on the same stops, in the same process."""

import time
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.real_car.answers import VEHICLE
from benchmarks.real_car.bound import Bound
from benchmarks.real_car.methods import METHODS
from benchmarks.real_car.stops import FOLLOWED
from benchmarks.rows import Row, at_most, not_judged
from corner_sim.car.pressure_prescription import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from friction_curve_id.methods import DEFAULT
from vehicle_models.vehicle_file import load_vehicle

Times = NDArray[np.float64]
_TIMES, _SLOWEST = 2.5, 1.5
"""Largest median in medians of the default, and largest 99th percentile [ms a wheel]."""


def timed(stop: Bound) -> Mapping[str, Times]:
    """CPU time of each sample of the stop of a random car [ms a wheel], by method."""
    car = random_car(stop.seed, stop.road, stop.family)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), stop.seed)
    beyond = run.tyre_slip > run.lambda_max
    last = float(run.time[beyond.any(axis=1).argmax()]) + FOLLOWED
    estimators = {name: make(load_vehicle(VEHICLE)) for name, make in METHODS.items()}
    found: dict[str, list[float]] = {name: [] for name in METHODS}
    for k in range(min(int(np.searchsorted(run.time, last)), len(run.time))):
        sample = float(run.time[k]), run.wheel_speed[k], run.brake_pressure[k], float(run.acceleration[k])
        for name, estimator in estimators.items():
            begin = time.thread_time_ns()
            estimator.update(*sample)
            found[name].append((time.thread_time_ns() - begin) * 1e-6 / run.wheel_speed.shape[1])
    return {name: np.array(times) for name, times in found.items()}


def cost_rows(stops: Sequence[Mapping[str, Times]]) -> list[Row]:
    """Rows of the methods; those beside the default are judged."""
    times = {name: np.concatenate([stop[name] for stop in stops]) for name in METHODS}
    reference = float(np.median(times[DEFAULT]))
    rows: list[Row] = []
    for name, found in times.items():
        median, slowest = float(np.median(found)), float(np.percentile(found, 99))
        start: Row = {"case": f"cost, {name}", "road": "all", "stops": len(stops)}
        relative = not_judged(1.0) if name == DEFAULT else at_most(median / reference, _TIMES)
        rows.append(start | {"quantity": "median CPU time of a sample [of the default]"} | relative)
        judged = not_judged(slowest) if name == DEFAULT else at_most(slowest, _SLOWEST)
        rows.append(start | {"quantity": "99th percentile [ms a wheel]"} | judged | {"median_ms": median})
    return rows
