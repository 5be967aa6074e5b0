"""Stops of one corner from 30 to 5 m/s with the supervisor in the loop, and their results."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.closed_loop.braked_corners import BrakedCorners
from benchmarks.closed_loop.controller import Parameters, processors
from benchmarks.closed_loop.longest_lock import LongestLock
from benchmarks.closed_loop.panic_stop import END_SPEED, LONGEST
from benchmarks.protocol import CAR, DT
from vehicle_models.vehicle import Vehicle

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
