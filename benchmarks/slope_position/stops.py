"""Stops with cycled slip: straight, in curves, on split and changing roads, with known and random cars.

The plant is corner_sim.car.cornering_car with its own tyres and sensors; messages go through wheel_slip and
friction_slope as in the graph. Truth: combined slip of the tyre beyond that of the peak of its road.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from friction_msgs.msg import FrictionSlope
from numpy.typing import NDArray

from benchmarks.cycled_stops import LEAST_SPEED, VEHICLE, drive, make_car, well_known
from benchmarks.cycled_stops import Case as CycledCase
from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling
from friction_parameters.parameter import changed
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph
from friction_slope.parameters import SHIPPED
from friction_slope.ros.processor import build
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Case(CycledCase):
    """A kind of stop, and what is wanted of it."""

    told: tuple[float, float] = (0.0, 0.0)
    """Wanted share of the samples beyond and before the peak that have a sign [%]."""
    right_signs: tuple[float, float] = (95.0, 95.0)
    """Wanted share of the signs -1 and +1 that are right [%]."""


def _cases() -> Iterator[Case]:
    for road in ("dry", "wet", "cobblestone"):
        yield Case(road, road, told=(80.0, 90.0), right_signs=(97.0, 99.0))
    yield Case("snow", "snow", told=(80.0, 85.0), right_signs=(95.0, 99.0))
    curves = (("dry", 0.3), ("dry", 0.6), ("wet", 0.5), ("snow", 0.12))
    for road, lateral in curves:
        yield Case(f"{road} {lateral} g", road, lateral=lateral, told=(60.0, 85.0), right_signs=(95.0, 98.0))
    for road, lateral in curves:
        yield Case(f"{road} {lateral} g, yaw not measured", road, lateral=lateral, across=False)
    yield Case("dry 0.8 g", "dry", lateral=0.8)
    for family in ("pacejka", "brush"):
        for road in ("dry", "wet", "snow"):
            yield Case(f"{family} {road}", road, family, told=(60.0, 85.0), right_signs=(95.0, 98.0))
    for family in ("burckhardt", "pacejka"):
        for road in ("dry", "wet", "cobblestone", "snow"):
            name = f"random, {family} {road}"
            yield Case(name, road, family, random=True, told=(60.0, 85.0), right_signs=(95.0, 98.0))
    for road, right in (("dry", "snow"), ("dry", "wet"), ("wet", "snow")):
        yield Case(f"split {road} | {right}", road, right=right)
    for road, after in (("dry", "snow"), ("snow", "dry"), ("dry", "wet"), ("wet", "dry")):
        yield Case(f"{road} to {after}", road, after=after)


Told = dict[tuple[str, int], tuple[int, float]]
"""Valid sign, 0 where none, and delay [s] by wheel and stamp [ns]."""

CASES: Final = {case.name: case for case in _cases()}


@dataclass(frozen=True)
class Stop:
    """What was told in a stop, arrays of shape (samples, wheels)."""

    time: Array
    """(samples,)"""
    beyond: Flags
    """Truth."""
    judged: Flags
    """(samples,)"""
    sign: Array
    """Valid signs at the time that they are of, their delay before their stamp; 0 where none."""
    told_at: Array
    """The same at their stamps."""


def make_stop(job: tuple[str, str, int]) -> Stop:
    """Drive a case, by name, and estimate by a method; the third is the seed."""
    name, method, seed = job
    case = CASES[name]
    parameters, cycling = make_car(case, seed)
    vehicle = load_vehicle(VEHICLE)
    return _follow(case, parameters, cycling, vehicle if case.random else well_known(vehicle), method, seed)


def _follow(case: Case, parameters: CarParameters, cycling: Cycling, vehicle: Vehicle, method: str, seed: int) -> Stop:
    graph = graph_of(vehicle, method)
    answers: Told = {}
    truth = []
    stamps = []
    for at in drive(case, parameters, cycling, seed):
        stamps.append(at.stamp)
        truth.append([at.time, *at.slip, *at.lambda_max, at.speed])
        take(graph, at.messages, answers)
    table = np.array(truth)
    time = table[:, 0]
    told_at, sign = sign_tables(time, stamps, vehicle.wheel_names, answers)
    judged = (time > cycling.start + 0.1) & (table[:, 9] > LEAST_SPEED)
    return Stop(time, table[:, 1:5] > table[:, 5:9], judged, sign, told_at)


def sign_tables(time: Array, stamps: Sequence[int], wheels: Sequence[str], told: Told) -> tuple[Array, Array]:
    """Return the signs at their stamps [ns], and at the times [s] that they are of, each of shape (samples, wheels)."""
    told_at = np.zeros((len(time), len(wheels)))
    sign = np.zeros_like(told_at)
    for k, stamp in enumerate(stamps):
        for i, wheel in enumerate(wheels):
            told_at[k, i], delay = told.get((wheel, stamp), (0, 0.0))
            at = int(np.searchsorted(time, time[k] - delay - 1e-6))
            sign[min(at, len(time) - 1), i] = told_at[k, i]
    return told_at, sign


def graph_of(vehicle: Vehicle, method: str) -> ProcessorGraph:
    """Return wheel_slip and friction_slope of a car, without the votes where they are apart."""
    slope = changed(SHIPPED["friction_slope"].parameters, {"method": method})
    estimates = [each for each in build(slope, vehicle) if FrictionSlope in each.outputs.values()]
    return ProcessorGraph([CarProcessor(vehicle, SHIPPED_SLIP["wheel_slip"].parameters), *estimates])


def take(graph: ProcessorGraph, sample: Sequence[tuple[str, Any]], told: Told) -> None:
    """Feed the messages of a sample, and note the signs that come of them."""
    for topic, message in sample:
        for _, answer in graph.feed(topic, message):
            if isinstance(answer, FrictionSlope):
                note(answer, told)


def note(message: FrictionSlope, told: Told) -> None:
    """Note a sign, 0 where it is not valid, and its delay."""
    delay = message.delay if np.isfinite(message.delay) else 0.0
    sign = message.sign if message.validity.valid else 0
    told[message.wheel, to_nanoseconds(message.header.stamp)] = (sign, delay)
