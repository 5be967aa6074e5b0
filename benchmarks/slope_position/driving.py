"""Ordinary driving of random cars on all roads, in curves too: no lasting sign -1."""

from typing import Any, Final

import numpy as np

from benchmarks.cycled_stops import VEHICLE, sensor_messages
from benchmarks.runner import Row, at_most, not_judged, run_lengths
from benchmarks.slope_position.stops import Told, graph_of, take
from corner_sim.car.car import STEP
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.cross_axes import CrossAxes
from corner_sim.car.driving import OrdinaryDriver
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import random_car
from vehicle_models.vehicle_file import load_vehicle

LASTING: Final = 0.05
"""Time for which a sign -1 is a claim [s]."""
DRIVE: Final = 180.0
"""Length of a drive [s]."""
START: Final = 12.0
ROADS: Final = ("dry", "wet", "cobblestone", "snow")


def make_drive(job: tuple[str, int]) -> tuple[int, float, float, float]:
    """Drive with a method and a seed.

    Returns:
        Lasting claims of all wheels, samples with a sign -1 and with a sign +1 [%], time braked [s].
    """
    method, seed = job
    car = random_car(seed, ROADS[seed % len(ROADS)], ("burckhardt", "pacejka")[seed // len(ROADS) % 2]).parameters
    vehicle = load_vehicle(VEHICLE)
    moving = CorneringCar(car, START, seed)
    measured, driver = MeasuredCar(car, START, seed, moving), OrdinaryDriver(car, seed)
    axes = CrossAxes(np.random.default_rng([seed, 21]))
    graph = graph_of(vehicle, method)
    told: Told = {}
    braked = 0.0
    for step in range(round(DRIVE / STEP)):
        if step % measured.steps_per_sample == 0:
            _, sample = sensor_messages(measured, moving, vehicle, axes)
            take(graph, sample, told)
        around = driver.surroundings(measured.time, moving)
        pressure = driver.pressure(measured.time, STEP, moving)
        braked += STEP * (max(pressure) > 0.0)
        measured.step(pressure, around.engine_torque, around.slope, around.curvature)
    signs = signs_of(told, vehicle.wheel_names)
    samples = measured.steps_per_sample * STEP
    lasting = int(np.sum(run_lengths(signs < 0) * samples > LASTING))
    return lasting, 100.0 * float(np.mean(signs < 0)), 100.0 * float(np.mean(signs > 0)), braked


def signs_of(told: Told, wheels: tuple[str, ...]) -> Any:
    """Signs at all stamps in order, shape (samples, wheels), 0 where none."""
    stamps = sorted({stamp for _, stamp in told})
    return np.array([[told.get((wheel, stamp), (0, 0.0))[0] for wheel in wheels] for stamp in stamps])


def driving_rows(results: list[tuple[int, float, float, float]]) -> list[Row]:
    """Rows of all drives."""
    lasting, beyond, stable, braked = (np.array(column) for column in zip(*results, strict=True))
    start = {"case": "ordinary driving", "stops": len(results)}
    return [
        start | {"quantity": f"signs -1 longer than {LASTING} s", **at_most(float(lasting.sum()), 0.0)},
        start | {"quantity": "samples with a sign -1 [%]", **not_judged(float(beyond.mean()))},
        start | {"quantity": "samples with a sign +1 [%]", **not_judged(float(stable.mean()))},
        start | {"quantity": "time braked [%]", **not_judged(100.0 * float(braked.sum()) / (DRIVE * len(results)))},
    ]
