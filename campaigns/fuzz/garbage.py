"""Hostile input: a clean drive, its messages broken, raw bytes; and a check for impossible values called valid."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from math import inf, isinf, isnan, pi
from typing import Any

import numpy as np
from numpy.random import Generator

from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, closed_loop_parameters, make_processors
from friction_bringup.graph import plant_calibration
from friction_parameters.parameter import from_mapping
from friction_runtime.processor import ProcessorGraph, silent
from vehicle_models.physical_bounds import HIGHEST_SPEED, HIGHEST_WHEEL_SPEED
from vehicle_models.vehicle import Vehicle

START = 10**12
"""Stamp of the first sample [ns]."""


def fuzzed_parameters() -> dict[str, Any]:
    """Return the parameters of the nodes, by name: the supervisor commands, and the tyres are calibrated."""
    found = closed_loop_parameters(ESTIMATORS)
    found[SMART_TYRE] = replace(found[SMART_TYRE], calibration_file=str(plant_calibration()))
    return found


def clean_run(vehicle: Vehicle, seconds: float) -> list[tuple[str, Any]]:
    """Return topics and messages in the order of the data flow.

    Args:
        vehicle: the car.
        seconds: length of the drive; braking begins after 0.5 s.
    """
    given = {
        "demand_level": 1.2,
        "demand_start": 0.5,
        "demand_rise": 0.3,
        "end_time": seconds,
        "acceleration_variance": 0.01,
        "tyre_signals": True,
        "vehicle_velocity": False,
    }
    simulation = Simulation(from_mapping(SimParameters, given), vehicle, START)
    graph = ProcessorGraph(make_processors(fuzzed_parameters(), vehicle, silent))
    run: list[tuple[str, Any]] = []
    while simulation.end is None:
        for topic, message in simulation.messages():
            if not topic.startswith("truth/"):
                run.append((topic, message))
                run.extend(graph.feed(topic, message))
        simulation.advance()
    return run


def inputs_of(processor: Any, run: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Return the part of a run that a processor takes."""
    topics = {*processor.sensors, *processor.estimates}
    return [(topic, message) for topic, message in run if topic in topics]


_FLOATS = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 1e-300, 1e18, -1e9, 3.6, -1.0, 9.81, 1e5)
_FLOATS32 = (np.nan, np.inf, -np.inf, 0.0, 3e38, -3e38, 1e-38, 1e9, -1.0, 5.0)
_BITS = {"8": 8, "16": 16, "32": 32, "64": 64}
_LONG = 100_000
"""Length of an array that is far too long."""
_RARELY = 1e-3
"""Share of the messages with arrays of this length: one takes as much time as a thousand others."""
_TEXTS = ("", "x", "front_left", "rear_right", "vehicle", "\u20ac" * 100, "wheel\n\x00")


def garbage(message: Any, rng: Generator) -> Any:
    """Return a copy of a message with one to three fields, at any depth, that hold something else.

    Rarely, all its arrays are far too long.
    """
    broken = deepcopy(message)
    if rng.random() < _RARELY:
        for name, kind in broken.get_fields_and_field_types().items():
            value = getattr(broken, name)
            if kind.startswith("sequence<") and len(value):
                setattr(broken, name, _joined(*[value] * (_LONG // len(value))))
        return broken
    for _ in range(int(rng.integers(1, 4))):
        _break(broken, rng)
    return broken


def _break(message: Any, rng: Generator) -> None:
    kinds = message.get_fields_and_field_types()
    name = str(rng.choice(list(kinds)))
    value = getattr(message, name)
    if hasattr(value, "get_fields_and_field_types"):
        _break(value, rng)
    elif isinstance(value, (array, np.ndarray, list)):
        setattr(message, name, _other_sequence(value, kinds[name], rng))
    else:
        setattr(message, name, _other(value, kinds[name], rng))


def _other(value: Any, kind: str, rng: Generator) -> Any:
    """Another value of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return str(rng.choice(_TEXTS))
    if isinstance(value, float):
        return float(rng.choice(_FLOATS)) if rng.random() < 0.8 else float(value * 10.0 ** rng.uniform(-6, 6))
    if isinstance(value, int):
        return _integer(value, kind, rng)
    return value


def _integer(value: int, kind: str, rng: Generator) -> int:
    bits = next((_BITS[size] for size in _BITS if kind.endswith(size)), 8)
    low, high = (0, 2**bits - 1) if kind.startswith("u") or bits == 8 else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if kind == "int8":
        low, high = -128, 127
    choices = (
        low,
        high,
        0,
        1,
        value + 1,
        value - 1,
        value + 1000,
        value + 2**53,
        value + 2**60,
        int(rng.integers(0, 2**31)),
    )
    return min(max(choices[int(rng.integers(len(choices)))], low), high)


def _other_sequence(value: Any, kind: str, rng: Generator) -> Any:
    """Another length, or other elements."""
    if len(value) == 0:
        return value
    fixed = not kind.startswith("sequence<")
    choice = 1.0 if fixed else rng.random()
    if choice < 0.1:
        return value[:0]
    if choice < 0.3:
        return value[: int(rng.integers(len(value)))]
    if choice < 0.5:
        return _joined(value, value)
    return _with_other_element(value, kind, rng)


def _joined(*parts: Any) -> Any:
    joined = parts[0][:]
    for part in parts[1:]:
        joined.extend(part)
    return joined


def _with_other_element(value: Any, kind: str, rng: Generator) -> Any:
    changed = value.copy() if isinstance(value, np.ndarray) else value[:]
    number = int(rng.integers(len(changed)))
    element = changed[number]
    if hasattr(element, "get_fields_and_field_types"):
        _break(element, rng)
    elif "float" in kind:
        changed[number] = float(rng.choice(_FLOATS32))
    elif "double" in kind:
        changed[number] = float(rng.choice(_FLOATS))
    else:
        changed[number] = _other(element, kind.removeprefix("sequence<").removesuffix(">"), rng)
    return changed


_WITHIN = {
    "WheelSlip": {
        "slip": (-1.5, 1.5),
        "slip_rate": (-inf, inf),
        "vehicle_speed": (-HIGHEST_SPEED, HIGHEST_SPEED),
        "wheel_speed": (-HIGHEST_WHEEL_SPEED, HIGHEST_WHEEL_SPEED),
        "slip_stddev": (0.0, 1.0),
    },
    "FrictionSlope": {"sign": (-1, 1), "indicator": (-inf, inf)},
    "FrictionCurve": {"lambda_max": (0.0, 1.0), "mu_max": (0.0, 2.5)},
    "ContactPatch": {"length": (0.0, pi), "shift": (-pi, pi)},
    "TyreForce": {"fx": (-1e5, 1e5), "fz": (-1e4, 1e5)},
}
"""Fields of a valid message, with what they lie within; an infinite or missing value never does."""
_ALWAYS = {
    "FrictionSlope": {"slip_at_crossing": (-1.5, 1.5)},
    "FrictionCurve": {"probability_beyond_peak": (0.0, 1.0), "lambda_max": (0.0, 1.0)},
}
"""Fields that are NaN or lie within, valid or not."""


def impossible(message: Any) -> str:
    """Return what is impossible in the answer of a processor, empty where all may be."""
    kind = type(message).__name__
    if hasattr(message, "validity") and message.validity.valid:
        for name, (low, high) in _WITHIN.get(kind, {}).items():
            value = getattr(message, name)
            if isnan(value) or isinf(value) or not low <= value <= high:
                return f"{kind}: valid with {name} = {value}"
    for name, (low, high) in _ALWAYS.get(kind, {}).items():
        value = getattr(message, name)
        if not isnan(value) and not low <= value <= high:
            return f"{kind}: {name} = {value}"
    return ""


_ENCAPSULATION = 4
_LONGEST = 4096


def raw_garbage(serialized: bytes, rng: Generator) -> bytes:
    """Return something else in place of a serialized message: broken, cut, of another encapsulation, or noise."""
    kind = int(rng.integers(6))
    if kind == 0:
        return bytes(rng.bytes(int(rng.integers(_LONGEST))))
    if kind == 1:
        return serialized[: int(rng.integers(len(serialized)))]
    if kind == 2:
        return bytes(rng.bytes(_ENCAPSULATION)) + serialized[_ENCAPSULATION:]
    if kind == 3:
        return serialized + bytes(rng.bytes(int(rng.integers(_LONGEST))))
    if kind == 4:
        return _flipped(serialized, rng)
    return _with_long_length(serialized, rng)


def _flipped(serialized: bytes, rng: Generator) -> bytes:
    """Flip one to twenty bits."""
    broken = bytearray(serialized)
    for _ in range(int(rng.integers(1, 21))):
        broken[int(rng.integers(len(broken)))] ^= 1 << int(rng.integers(8))
    return bytes(broken)


def _with_long_length(serialized: bytes, rng: Generator) -> bytes:
    """Claim a length of up to 4 GiB somewhere, where the length of a text or of an array may stand."""
    broken = bytearray(serialized)
    words = max((len(broken) - _ENCAPSULATION) // 4, 1)
    begin = _ENCAPSULATION + 4 * int(rng.integers(words))
    broken[begin : begin + 4] = int(rng.integers(2**24, 2**32)).to_bytes(4, "little")
    return bytes(broken)
