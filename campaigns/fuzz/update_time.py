"""Longest time of an update, and sensors in wrong units."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from friction_msgs.msg import TyreSignals
from numpy.typing import NDArray
from rich.progress import track
from sensor_msgs.msg import FluidPressure, Imu

from benchmarks.runner import Row, at_least, at_most, not_judged
from campaigns.fuzz.garbage import START, inputs_of
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreSignalSource
from friction_bags.offline.estimators import SMART_TYRE, closed_loop_parameters, make_processors
from friction_parameters.parameter import from_mapping
from friction_runtime.messages import header_at
from friction_runtime.processor import ProcessorGraph, silent
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

_RATE = 1e4
"""Samples of a tyre in a second."""
_LEAD_IN = 30_000
"""Samples of a drive before it, in which the angle of the wheel becomes known."""
_LONG = 100_000
"""Samples of a block that is far too long: 10 s."""
_WHEEL = "front_left"
_LARGEST_UPDATE = 0.1
"""Largest CPU time of an update in ordinary driving [s]: what subscribers' queues hold is five times that."""
_LARGEST_LONG_UPDATE = 1.0
"""Largest CPU time of a block of _LONG samples [s], a tenth of the time that it spans."""
_REPEATS = 2
"""The least of so many runs counts: other processes of the machine are no part of an update."""
Signal = NDArray[np.float32]
_PARTS = (*(slice(begin, begin + 50) for begin in range(0, _LEAD_IN, 50)), slice(_LEAD_IN, _LEAD_IN + _LONG))
"""Blocks as a sensor sends them, then the long one."""


def update_time_rows(makers: Mapping[str, Callable[[], Any]], drive: Sequence[tuple[str, Any]]) -> list[Row]:
    """Return a row for each processor with its slowest update, and one for each long block of a tyre.

    Args:
        makers: make a processor each, by name.
        drive: the clean drive, whose braking fills the windows of all methods.
    """
    rows: list[Row] = []
    for name, make in makers.items():
        inputs = inputs_of(make(), drive)
        slowest = min(_slowest(make(), inputs) for _ in range(_REPEATS))
        rows.append(_row(name, len(inputs), "clean drive", at_most(slowest, _LARGEST_UPDATE)))
    if SMART_TYRE in makers:
        for what, voltage, acceleration in _long_blocks():
            blocks = [_block(part, voltage[part], acceleration[part]) for part in _PARTS]
            slowest = min(_slowest(makers[SMART_TYRE](), blocks) for _ in range(_REPEATS))
            rows.append(_row(SMART_TYRE, len(blocks), what, at_most(slowest, _LARGEST_LONG_UPDATE)))
    return rows


def _row(name: str, messages: int, what: str, result: Row) -> Row:
    quantity = f"slowest update, {what} [s]"
    return {"processor": name, "messages": messages, "quantity": quantity, **result, "first": ""}


def _slowest(processor: Any, inputs: Sequence[tuple[str, Any]]) -> float:
    slowest = 0.0
    for topic, message in inputs:
        begun = time.thread_time()
        processor.process(topic, message)
        slowest = max(slowest, time.thread_time() - begun)
    return slowest


def _long_blocks() -> Iterator[tuple[str, Signal, Signal]]:
    """Yield names, voltages and accelerations: a drive, and what makes most crossings of the encoder."""
    ring = TyreRing()
    # The first wheel of the plant, whose teeth the calibration knows.
    source = TyreSignalSource(ring, AccelerometerParameters(), EncoderParameters(), wheel_seed=0, noise_seed=1)
    drive = source.advance(np.full(_LEAD_IN + _LONG, 20.0 / ring.radius), 0.0, ring.static_load)
    voltage, acceleration = drive.encoder_voltage, drive.radial_acceleration
    yield f"{_LONG} samples of a drive", voltage, acceleration
    swapping = np.where(np.arange(_LONG) % 2 == 0, 1.0, -1.0).astype(np.float32)
    yield f"{_LONG} samples that cross zero each time", np.append(voltage[:_LEAD_IN], swapping), acceleration
    noise = np.random.default_rng(0).normal(0.0, 1.0, (2, _LONG)).astype(np.float32)
    noisy = [np.append(each[:_LEAD_IN], noise[k]) for k, each in enumerate((voltage, acceleration))]
    yield f"{_LONG} samples of noise", noisy[0], noisy[1]


def _block(part: slice, voltage: Signal, acceleration: Signal) -> tuple[str, TyreSignals]:
    message = TyreSignals(
        header=header_at(START + round(part.start / _RATE * NANOSECONDS), _WHEEL),
        wheel=_WHEEL,
        sample_rate=_RATE,
        first_sample=part.start,
        encoder_voltage=array("f", voltage.tobytes()),
        radial_acceleration=array("f", acceleration.tobytes()),
        inflation_pressure=2e5,
    )
    return f"{_WHEEL}/tyre_signals", message


CORNER, CAR = "chapter_corner", "compact_car"
_MODELS = {CORNER: "single_corner", CAR: "car"}
SURFACES = ("dry", "wet", "cobblestone", "snow")
GENTLE, HARD = "gentle", "hard"
_DEMANDS: Mapping[str, Mapping[str, float]] = {
    GENTLE: {"demand_level": 0.3, "demand_rise": 1.0},
    HARD: {"demand_level": 1.2, "demand_rise": 0.3},
}
_SECONDS = 4.0
_NAMES = ("in bar", "converted from bar", "MPa", "in g", "wrong sign")
"""What says that a unit is suspected."""
Stop = Sequence[tuple[str, Any]]
Change = Callable[[Any], None]


def _pressure(factor: float) -> Change:
    def change(message: Any) -> None:
        if isinstance(message, FluidPressure):
            message.fluid_pressure *= factor

    return change


def _acceleration(factor: float) -> Change:
    def change(message: Any) -> None:
        if isinstance(message, Imu):
            message.linear_acceleration.x *= factor

    return change


_SLOPE, _CURVE, _SLIP = "friction_slope", "friction_curve", "slip"
_SABOTAGES: Mapping[str, tuple[Change, tuple[str, ...]]] = {
    "pressure in bar": (_pressure(1e-5), (_SLOPE, _CURVE)),
    "pressure 1e5 times too large": (_pressure(1e5), (_SLOPE, _CURVE)),
    "acceleration of the wrong sign": (_acceleration(-1.0), (_SLIP,)),
    "acceleration in g": (_acceleration(1.0 / 9.81), (_SLIP,)),
}
"""What is changed, and the topics of every wheel that must name it."""
_NOT_BY_WHEELS_ALONE = "acceleration in g"
"""Wheels that slip do not tell how fast the car slows down: the road may be ice. The method car has the pressures."""


def wrong_unit_rows(cars: Sequence[str] = (CORNER, CAR), surfaces: Sequence[str] = SURFACES) -> list[Row]:
    """Return for each car, braking and fault how many of the roads have it named, and what was valid afterwards."""
    rows: list[Row] = []
    for name, braking in track([(car, braking) for car in cars for braking in _DEMANDS], description="units"):
        car = load_vehicle(name)
        stops = [_stop(name, car, surface, braking) for surface in surfaces]
        where = {"processor": f"{name}, {braking}", "messages": sum(map(len, stops))}
        healthy = sum(bool(_naming(_answers(car, stop, lambda message: None))) for stop in stops)
        rows.append({**where, "quantity": "stops with a unit named where all are right", **at_most(healthy, 0)})
        for what, (change, topics) in _SABOTAGES.items():
            found = [_answers(car, stop, change) for stop in stops]
            wanted = (*topics, _CURVE) if name == CAR and _SLIP in topics else topics
            for topic in dict.fromkeys(wanted):
                named = sum(topic in _naming(answers) for answers in found)
                judged = what != _NOT_BY_WHEELS_ALONE or topic == _CURVE or (name, braking) == (CORNER, GENTLE)
                result = at_least(named, len(stops)) if judged else not_judged(named)
                rows.append({**where, "quantity": f"stops of {len(stops)} with {what} named on {topic}", **result})
                wrong = sum(_valid_although_named(answers, topic) for answers in found)
                rows.append({**where, "quantity": f"valid on {topic} once {what} is named", **at_most(wrong, 0)})
    return rows


def _stop(name: str, car: Vehicle, surface: str, braking: str) -> Stop:
    """Return the sensors of a stop without a supervisor."""
    given = {
        **_DEMANDS[braking],
        "model": _MODELS[name],
        "surfaces": [surface],
        "demand_start": 0.5,
        "end_time": _SECONDS,
        "end_speed": 1.0,
        "acceleration_variance": 0.01,
        "vehicle_velocity": False,
    }
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in given.items()}
    simulation = Simulation(from_mapping(SimParameters, values), car, START)
    stop: list[tuple[str, Any]] = []
    while simulation.end is None:
        stop += [each for each in simulation.messages() if not each[0].startswith("truth/")]
        simulation.advance()
    return stop


def _answers(car: Vehicle, stop: Stop, change: Change) -> dict[str, list[Any]]:
    """Return the answers to a stop whose sensors are changed, by the last part of their topic."""
    law = "curve" if len(car.wheels) > 1 else "slope_sign"
    nodes = ("wheel_slip", _SLOPE, "friction_curve_id", "abs_supervisor")
    graph = ProcessorGraph(make_processors(closed_loop_parameters(nodes, law), car, silent))
    found: dict[str, list[Any]] = {}
    for topic, message in stop:
        changed = deepcopy(message)
        change(changed)
        for answered, answer in graph.feed(topic, changed):
            found.setdefault(answered.rpartition("/")[2], []).append(answer)
    return found


def _naming(answers: Mapping[str, Sequence[Any]]) -> set[str]:
    """Return the estimates that name a unit, of whatever wheel."""
    return {topic for topic in (_SLIP, _SLOPE, _CURVE) if any(map(_names, answers.get(topic, ())))}


def _names(answer: Any) -> bool:
    return any(each in answer.validity.text for each in _NAMES)


def _valid_although_named(answers: Mapping[str, Sequence[Any]], topic: str) -> int:
    """Count the valid answers of a wheel after its first one that names a unit."""
    named: set[str] = set()
    count = 0
    for answer in answers.get(topic, ()):
        if _names(answer):
            named.add(answer.wheel)
        count += answer.validity.valid and answer.wheel in named
    return count
