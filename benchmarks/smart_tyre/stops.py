"""Forces of the smart tyres through the whole stop of the demo, on its four roads.

The car of the demo brakes to standstill with the graph in the loop, once for each road; the signals of the tyres are
then made with several seeds of their noise. The estimator is that of the node with the calibration that is shipped.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from friction_msgs.msg import TyreForce, TyreSignals
from numpy.typing import NDArray
from rich.progress import Progress
from sensor_msgs.msg import FluidPressure, Imu

from benchmarks.closed_loop import loop_parameters, take_sample
from benchmarks.runner import Row, at_least, at_most
from corner_sim.car_plant import CarModelParameters, in_order
from corner_sim.parameters import SimParameters
from corner_sim.ros.messages import tyre_signals
from corner_sim.ros.simulation import Simulation
from corner_sim.smart_tyre.tyre_signal import TyreSignalSource
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, make_processors
from friction_bringup.demo_drive import plant_of_demo
from friction_bringup.graph import PLANT, plant_calibration
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph, silent
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.ros.processor import TyreProcessor
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import FRONT, REAR
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]
ROADS = ("dry", "wet", "cobblestone", "snow")
VEHICLE = "compact_car"
CAR = in_order(load_vehicle(VEHICLE))
_START = 10_000 * NANOSECONDS
_LONGEST = 25.0
"""Longest stop [s]."""
_RATE = 1e4
_BLOCK = 50
_VALID, _COVERAGE = 95.0, 90.0
LIMITS = {"fz": 1.5, "fx": 5.0}
"""RMSE in % of the static load."""
Message: TypeAlias = Imu | FluidPressure


@dataclass
class Stop:
    """What the estimator hears of the car in one stop, and the true motion of the wheels."""

    onset: int
    """Stamp [ns]."""
    sensors: list[tuple[int, str, Message]] = field(default_factory=list)
    """Stamp [ns], topic and message."""
    wheels: dict[str, list[tuple[float, float, float, float]]] = field(default_factory=dict)
    """Time [s], wheel speed [rad/s], Fx and Fz [N] by the wheel."""


def stop_of_demo(road: str, seed: int = 1) -> Stop:
    """Brake once, with the graph in the loop."""
    drive: Mapping[str, Any] = plant_of_demo(road, VEHICLE)[PLANT]
    onset = drive["demand_start"]
    plant = SimParameters(
        vehicle_file=VEHICLE,
        model=drive["model"],
        initial_speed=drive["initial_speed"],
        surfaces=(road,),
        car=CarModelParameters(
            drive_times=tuple(drive["car.drive_times"]), drive_speeds=tuple(drive["car.drive_speeds"])
        ),
        demand_start=onset,
        acceleration_variance=drive["acceleration_variance"],
        vehicle_velocity=False,
        end_speed=0.3,
        seed=seed,
    )
    simulation = Simulation(plant, CAR, _START)
    graph = ProcessorGraph(make_processors(loop_parameters(WHEEL_ESTIMATORS, "curve"), CAR, silent))
    stop = Stop(_START + round(onset * NANOSECONDS), wheels={wheel: [] for wheel in CAR.wheel_names})
    turning: dict[str, float] = {}
    while simulation.end is None and simulation.time < onset + _LONGEST:
        for topic, message in take_sample(simulation, graph):
            if isinstance(message, Imu | FluidPressure) and not topic.startswith("truth/"):
                stop.sensors.append((simulation.stamp, topic, message))
            elif topic.startswith("truth/") and topic.endswith("/slip"):
                turning[message.wheel] = message.wheel_speed
            elif topic.startswith("truth/") and topic.endswith("/tyre_force"):
                now = (simulation.stamp - _START) / NANOSECONDS
                stop.wheels[message.wheel].append((now, turning[message.wheel], message.fx, message.fz))
        simulation.advance()
    return stop


@dataclass(frozen=True)
class Judged:
    """Revolutions of one wheel from the onset on."""

    revolutions: int
    error: dict[str, Array]
    """Of the valid forces [N]."""
    stddev: dict[str, Array]


def judge(stop: Stop, wheel: str, known: Calibration, seed: int) -> Judged:
    """Run the processor of a wheel through a stop, with one seed of the noise of its signals."""
    time, turning, fx, fz = np.array(stop.wheels[wheel]).T
    number = CAR.wheel_names.index(wheel)
    source = TyreSignalSource(wheel_seed=number, noise_seed=1000 * seed + number, sample_rate=_RATE)
    processor = TyreProcessor(wheel, CAR, SmartTyreParameters(), known)
    revolutions, half = 0, 0.0  # half of the time that the last patch took [s]: its force is that of its middle
    error: dict[str, list[float]] = {name: [] for name in LIMITS}
    stddev: dict[str, list[float]] = {name: [] for name in LIMITS}
    for topic, message in _messages(stop, wheel, source, time, turning, fx, fz):
        for name, answer in processor.process(topic, message):
            if name.endswith("contact_patch"):
                half = 0.5 * answer.length_raw / answer.wheel_speed if answer.validity.valid else 0.0
            elif isinstance(answer, TyreForce) and to_nanoseconds(answer.header.stamp) >= stop.onset:
                revolutions += 1
                if answer.validity.valid:
                    when = (to_nanoseconds(answer.header.stamp) - _START) / NANOSECONDS - half
                    for quantity, true in (("fx", fx), ("fz", fz)):
                        error[quantity].append(getattr(answer, quantity) - float(np.interp(when, time, true)))
                        stddev[quantity].append(getattr(answer, f"{quantity}_stddev"))
    as_arrays = [{name: np.array(values) for name, values in each.items()} for each in (error, stddev)]
    return Judged(revolutions, *as_arrays)


def _messages(
    stop: Stop, wheel: str, source: TyreSignalSource, time: Array, turning: Array, fx: Array, fz: Array
) -> Iterator[tuple[str, Message | TyreSignals]]:
    sensed = 0
    for first in range(0, int(time[-1] * _RATE) - _BLOCK, _BLOCK):
        stamp = _START + round(first / _RATE * NANOSECONDS)
        while sensed < len(stop.sensors) and stop.sensors[sensed][0] <= stamp:
            yield stop.sensors[sensed][1:]
            sensed += 1
        at = (first + np.arange(_BLOCK)) / _RATE
        block = source.advance(*(np.interp(at, time, each) for each in (turning, fx, fz)))
        yield from tyre_signals(stamp, [wheel], [block], 0.0)


def rows(seeds: range, progress: Progress, roads: Sequence[str] = ROADS) -> Iterator[Row]:
    """Of each road a row for each axle and quantity."""
    known = Calibration.load(plant_calibration())
    task = progress.add_task("stops", total=len(roads) * len(seeds))
    for road in roads:
        stop = stop_of_demo(road)
        judged: dict[str, list[Judged]] = {FRONT: [], REAR: []}
        for seed in seeds:
            for wheel in CAR.wheels:
                judged[wheel.axle].append(judge(stop, wheel.name, known, seed))
            progress.advance(task)
        for axle, of_axle in judged.items():
            yield from _rows(road, axle, of_axle)


def _rows(road: str, axle: str, judged: list[Judged]) -> Iterator[Row]:
    row = {"case": f"stop of the demo, {road}", "axle": axle}
    valid = sum(len(each.error["fz"]) for each in judged) / sum(each.revolutions for each in judged)
    yield row | {"quantity": "revolutions with valid forces [%]"} | at_least(100.0 * valid, _VALID)
    load = next(CAR.corner(wheel.name).vertical_load for wheel in CAR.wheels if wheel.axle == axle)
    for name, limit in LIMITS.items():
        error = np.concatenate([each.error[name] for each in judged])
        stddev = np.concatenate([each.stddev[name] for each in judged])
        rmse = 100.0 * float(np.sqrt(np.mean(error**2))) / load
        yield row | {"quantity": f"F{name[1]} RMSE [%]"} | at_most(rmse, limit)
        inside = 100.0 * float(np.mean(np.abs(error) < 1.96 * stddev))
        yield row | {"quantity": f"F{name[1]} within 95 % interval [%]"} | at_least(inside, _COVERAGE)
