"""Metrics of a stop from full speed to standstill."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.closed_loop.longest_lock import LongestLock
from benchmarks.closed_loop.panic_plant import Array, Commands, Flags, PanicPlant
from benchmarks.protocol import DT

END_SPEED = 5.0
"""[m/s] first end of a stop."""
LOCK_ABOVE = 1.5
"""[m/s] below it the driver has the brake, and a lock does not count."""
LONGEST = 60.0
"""[s] after which a run is given up."""


@dataclass
class PanicStops:
    """Results of n stops, arrays of shape (n,)."""

    utilisation: Array
    """Mean of the deceleration over that at the present mu_max, from the onset to END_SPEED [-]."""
    utilisation_to_rest: Array
    """To standstill [-]."""
    distance: Array
    """From the onset to standstill [m]."""
    longest_lock: Array
    """[s] above LOCK_ABOVE."""
    changes: Array
    """Changes of the command in a second, above END_SPEED [1/s]."""
    stopped: Flags
    """Came to rest, and stayed."""


def brake_to_rest(plant: PanicPlant, brake: Callable[[Flags], Commands]) -> PanicStops:
    """Brake all corners of a plant to standstill.

    Args:
        plant: before the onset.
        brake: advances it by a sample; takes which corners still run, returns the commands, shape (n,).
    """
    corner = plant.corner
    count = corner.speed.size
    start, speed = corner.distance, corner.speed.copy()
    used_to_end, used = np.zeros(count), np.zeros(count)
    end_time, rest_time = np.full(count, np.nan), np.full(count, np.nan)
    changes = np.zeros(count)
    lock = LongestLock(count)
    before: Commands = np.ones(count, dtype=np.int64)
    running: Flags = np.ones(count, dtype=bool)
    while running.any() and plant.since < LONGEST:
        since, best = plant.since, plant.best_deceleration
        given = brake(running)
        changes += running & (given != before) & (speed > END_SPEED)
        before = given
        now = corner.speed
        crossed = (speed > END_SPEED) & (now <= END_SPEED)
        share = (speed - END_SPEED) / np.maximum(speed - now, 1e-12)
        lost = (speed - now) / best
        used_to_end += np.where(crossed, share * lost, lost * (now > END_SPEED))
        used += lost
        end_time = np.where(crossed, since + DT * share, end_time)
        lock.update(corner.slip, running & (now > LOCK_ABOVE))
        ended = running & (now <= 0.0)
        rest_time = np.where(ended, plant.since, rest_time)
        running = running & ~ended
        speed = now.copy()
    return PanicStops(
        utilisation=used_to_end / end_time,
        utilisation_to_rest=used / rest_time,
        distance=corner.distance - start,
        longest_lock=lock.longest,
        changes=changes / end_time,
        stopped=np.isfinite(rest_time) & (corner.speed <= 0.0),
    )
