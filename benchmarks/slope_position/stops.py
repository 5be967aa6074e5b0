"""Stops with cycled slip: straight, in curves, on split and changing roads, with known and random cars.

The plant is corner_sim.car.cornering_car with its own tyres and sensors; messages go through wheel_slip and
friction_slope as in the graph. Truth: combined slip of the tyre beyond that of the peak of its road.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from friction_msgs.msg import FrictionSlope
from numpy.typing import NDArray

from corner_sim.car.car import STEP
from corner_sim.car.car_parameters import PITCH_GAIN, CarParameters, SensorParameters
from corner_sim.car.cornering_car import CorneringCar
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import SPUN
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Scaled, Tyre
from corner_sim.ros import messages
from corner_sim.sensors import CHAPTER_NOISE, Measurement
from friction_parameters.parameter import changed
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph
from friction_slope.parameters import SHIPPED
from friction_slope.ros.processor import build
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Deviation, SharedBy, Vehicle
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.parameters import SHIPPED as SHIPPED_SLIP
from wheel_slip.ros.processor import CarProcessor

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

VEHICLE: Final = "compact_car"
FAMILIES: Mapping[str, Mapping[str, Tyre]] = {**TYRES, "brush": BRUSH_TYRES}
CYCLE: Final = Cycling(upper=1.4, lower=0.5)
"""Slip control that is better than most: barely beyond the peak, which is hardest to tell."""
SPEED: Final = 25.0
DURATION: Final = 2.3
"""Time of braking [s]."""
LEAST_SPEED: Final = 3.0
BEND: Final = 0.5
"""Time in which the curve begins [s]."""
CHANGED_AFTER: Final = 14.0
"""Way on the first road after the begin of braking [m]."""
LOAD_VARIATION: Final = 0.03
_ACCELERATION_VARIANCE: Final = 0.0025


@dataclass(frozen=True)
class Case:
    """A kind of stop."""

    name: str
    road: str
    family: str = "burckhardt"
    lateral: float = 0.0
    """Lateral acceleration of the curve at the start [g]."""
    right: str = ""
    """Road of the right wheels where it is another."""
    after: str = ""
    """Road after CHANGED_AFTER where it is another."""
    random: bool = False
    """A random car, of which the estimators know the nominal one; else one whose tyres alone are not known."""
    across: bool = True
    """Yaw rate and lateral acceleration are measured."""
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
    parameters, cycling = _car(case, seed)
    vehicle = load_vehicle(VEHICLE)
    return _follow(case, parameters, cycling, vehicle if case.random else well_known(vehicle), method, seed)


def well_known(vehicle: Vehicle) -> Vehicle:
    """Return a car whose brakes and wheels were measured: gains and inertias to 2 %, delay to 2 ms, drag to 5 N m."""

    def known(stddev: float) -> Deviation:
        return Deviation(stddev, SharedBy.ALL)

    wheels = tuple(
        replace(
            wheel,
            deviations={
                **wheel.deviations,
                "inertia": known(0.02 * wheel.inertia),
                "brake_gain": known(0.02 * wheel.brake_gain),
            },
        )
        for wheel in vehicle.wheels
    )
    of_car = {"brake_pressure_delay": known(0.002), "engine_drag_torque": known(5.0)}
    return replace(vehicle, wheels=wheels, deviations={**vehicle.deviations, **of_car})


def _car(case: Case, seed: int) -> tuple[CarParameters, Cycling]:
    if case.random:
        drawn = random_car(seed, case.road, case.family)
        return drawn.parameters, drawn.cycling
    rng = np.random.default_rng([seed, 5])
    roads = (case.road, case.right or case.road) * 2
    tyres = [
        Scaled(FAMILIES[case.family][road], 1.0 + 0.03 * float(rng.normal()), 1.0 + 0.05 * float(rng.normal()))
        for road in roads
    ]
    parameters = CarParameters(
        tyres=(tyres[0], tyres[1], tyres[2], tyres[3]),
        load_variation=LOAD_VARIATION,
        relaxation_length=(0.3,) * 4,
        pitch_gain=PITCH_GAIN,
        damper_share=float(rng.uniform(0.0, 1.0)),
        sensors=SensorParameters(acceleration_bias=float(rng.normal(0.0, 0.05))),
    )
    return parameters, CYCLE


def _follow(case: Case, parameters: CarParameters, cycling: Cycling, vehicle: Vehicle, method: str, seed: int) -> Stop:
    graph = graph_of(vehicle, method)
    answers: Told = {}
    truth = []
    stamps = []
    for stamp, sample, row in _drive(case, parameters, cycling, seed):
        stamps.append(stamp)
        truth.append(row)
        take(graph, sample, answers)
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


def sensor_messages(
    measured: MeasuredCar, car: CorneringCar, vehicle: Vehicle, bias: float, offset: float, rng: np.random.Generator
) -> tuple[int, list[tuple[str, Any]]]:
    """Return stamp [ns] and messages of a sample; the IMU has three axes, with a bias [m/s^2] and an offset [rad/s]."""
    reading = measured.measure()
    taken = Measurement(
        wheel_speed=np.array(reading.wheel_speed),
        brake_pressure=np.array(reading.brake_pressure),
        speed=np.nan,
        acceleration=reading.acceleration,
    )
    stamp = round((reading.time + 1.0) * NANOSECONDS)
    made = messages.sensors(stamp, vehicle, taken, CHAPTER_NOISE, _ACCELERATION_VARIANCE)
    imu = dict(made)["imu/data"]
    rolled = 0.04 * car.roll.angle
    imu.linear_acceleration.y = car.lateral_acceleration + rolled + bias + 0.05 * float(rng.normal())
    imu.angular_velocity.z = car.yaw_rate + offset + 0.003 * float(rng.normal())
    imu.angular_velocity_covariance[0] = 0.0
    return stamp, [each for each in made if each[0] != "vehicle_velocity"]


def _drive(
    case: Case, parameters: CarParameters, cycling: Cycling, seed: int
) -> Iterator[tuple[int, list[tuple[str, Any]], list[float]]]:
    """Stamp [ns], messages, and time, sizes of tyre slip, lambda_max and speed of each sample."""
    vehicle = load_vehicle(VEHICLE)
    car = CorneringCar(parameters, SPEED, seed)
    measured = MeasuredCar(parameters, SPEED, seed, car)
    pedal = SlipCycle(parameters, cycling)
    rng = np.random.default_rng([seed, 21])
    offset, bias = float(rng.normal(0.0, 0.01)), float(rng.normal(0.0, 0.1))
    after = FAMILIES[case.family][case.after] if case.after else None
    peak_after = after.peak[0] if after is not None else np.nan
    braked_at: float | None = None
    peaks = [tyre.peak[0] for tyre in car.tyres]
    for step in range(round((cycling.start + DURATION) / STEP)):
        time = measured.time
        if step % measured.steps_per_sample == 0:
            stamp, made = sensor_messages(measured, car, vehicle, bias, offset, rng)
            if not case.across:
                imu = dict(made)["imu/data"]
                imu.linear_acceleration.y, imu.angular_velocity.z = 0.0, 0.0
                imu.angular_velocity_covariance[0] = -1.0
            row = [time, *np.abs(car.tyre_slip).tolist(), *peaks, car.speed]
            yield stamp, made, row
        if car.speed < LEAST_SPEED or abs(car.lateral_speed) > SPUN * car.speed:
            return
        if braked_at is None and time >= cycling.start:
            braked_at = car.distance
        if after is not None and braked_at is not None:
            for wheel, behind in enumerate((0.0, 0.0, parameters.wheelbase, parameters.wheelbase)):
                if car.distance - braked_at - behind > CHANGED_AFTER:
                    car.tyres[wheel], peaks[wheel] = after, peak_after
        curvature = case.lateral * GRAVITY * min(time / BEND, 1.0) / max(car.speed, 5.0) ** 2
        measured.step(pedal.pressure(time, STEP, car), 0.0, 0.0, curvature)
