"""Rows of a car whose right wheels are on another road: way, moment about the vertical, and how fast it grows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.wheel_pair import NO_AXLE
from benchmarks.closed_loop.car_setup import MODELS, CarSetup
from benchmarks.closed_loop.car_stop import car_stop
from benchmarks.closed_loop.longest_lock import LOCK_TIME
from benchmarks.rows import Row
from corner_sim.models import CAR
from corner_sim.plant import SAMPLE_TIME
from vehicle_models.vehicle import REAR

SPLIT = "split"
"""Name of the car with other roads left and right."""
SPLITS = ("dry | snow", "wet | snow")
"""Left and right."""
_BETWEEN = " | "
_GROWTH = round(0.5 / SAMPLE_TIME)
"""Samples over which the growth of the moment is taken: a driver does not answer anything faster."""
_YAW_MOMENT_RATE = 5000.0
"""[N m/s] of the limit that is tried: a driver needs half a second to steer against what a dry road gives."""


@dataclass(frozen=True)
class Coupling:
    """What the wheels of an axle know of each other."""

    name: str
    select_low: str = NO_AXLE
    yaw_moment_rate: float = 0.0


COUPLINGS = (
    Coupling("each wheel alone"),
    Coupling("select-low rear", REAR),
    Coupling("select-low rear, moment limited", REAR, _YAW_MOMENT_RATE),
)


def chosen_splits(surfaces: Sequence[str], cases: Sequence[str]) -> list[tuple[str, Coupling]]:
    """Return roads and couplings of which rows are made."""
    return [
        (road, coupling)
        for road in SPLITS
        for coupling in COUPLINGS
        if (not surfaces or road in surfaces) and (not cases or coupling.name in cases)
    ]


def split_setup(road: str, coupling: Coupling) -> CarSetup:
    """Return the car on a road of SPLITS."""
    left, right = road.split(_BETWEEN)
    (car,) = (name for name, model in MODELS.items() if model == CAR)
    return replace(
        CarSetup(car, left),
        right_surface=right,
        select_low=coupling.select_low,
        yaw_moment_rate=coupling.yaw_moment_rate,
    )


def largest_growth(moments: NDArray[np.float64]) -> float:
    """Return the fastest growth of the size of a moment [N m/s], of its samples [N m], shape (k,)."""
    size = np.abs(moments)
    return float(np.max(size[_GROWTH:] - size[:-_GROWTH])) / (_GROWTH * SAMPLE_TIME)


def split_row(law: str, seeds: range, road: str, coupling: Coupling) -> Row:
    """Return the row of a road of SPLITS and a coupling, for information; `seeds` are of sensor noise and road."""
    setup = split_setup(road, coupling)
    stops = [car_stop(setup, seed, law) for seed in seeds]
    found, moments = [stop for stop, _ in stops], [moment for _, moment in stops]
    return {
        "car": SPLIT,
        "surface": road,
        "case": coupling.name,
        "law": law,
        "seeds": len(seeds),
        "value": float(np.mean([stop.utilisation[0] for stop in found])),
        "limit": None,
        "passed": None,
        "worst": float(min(stop.utilisation[0] for stop in found)),
        "to_standstill": float(np.mean([stop.utilisation_to_rest[0] for stop in found])),
        "distance_m": float(np.mean([stop.distance[0] for stop in found])),
        "largest_moment_Nm": float(max(np.abs(moment).max() for moment in moments)),
        "largest_growth_Nm_per_s": max(largest_growth(moment) for moment in moments),
        "longest_lock_s": float(max(stop.longest_lock[0] for stop in found)),
        "runs_with_lock": sum(bool(stop.longest_lock[0] >= LOCK_TIME) for stop in found),
        "commands_per_s": float(np.mean([stop.changes[0] for stop in found])),
    }
