"""Rows of `abs --law`: utilisation, distance and lock time by car, surface and perturbation, beside their bounds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from abs_supervisor.axle import NO_AXLE
from benchmarks.abs.bounds import ActuatorBound, actuator_bound, car_bound, ideal_controller
from benchmarks.abs.car import CarSetup, car_stop, car_stops
from benchmarks.abs.controllers import law_stops
from benchmarks.abs.panic_stop import (
    CAR_PERTURBATIONS,
    CHANGES,
    LOCK_TIME,
    NONE,
    PERTURBATIONS,
    PanicStops,
    Perturbation,
)
from benchmarks.abs.random_cars import FAMILIES, RANDOM, random_row
from benchmarks.abs.tyre_force_crosscheck import SMART_TYRES, opinion_row
from benchmarks.engine import results_of
from benchmarks.protocol import CORNER, DT, SPEED
from benchmarks.runner import Row
from corner_sim.plant import SAMPLE_TIME
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface
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
    return replace(
        CarSetup(left),
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
    cars = [car_stop(setup, seed, law) for seed in seeds]
    found, moments = [car.stops for car in cars], [car.yaw_moment for car in cars]
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


CORNER_ALONE, WHOLE_CAR = "corner", "car"
_USUAL = (CORNER_ALONE, WHOLE_CAR, SPLIT)
"""The single corner without speed sensor, a car with four wheels, and one with other roads left and right."""
CARS = (*_USUAL, RANDOM, SMART_TYRES)
"""Only where they are named: random cars, and the one whose tyres are asked beside the loop (a minute a stop)."""
FIRST_SEED = 30_000
"""Far from the seeds of the tuning, from 1000 on."""
_UTILISATION = {"dry": 0.950, "wet": 0.972, "cobblestone": 0.953, "snow": 0.988}
"""At least, where the car is known exactly, to 5 m/s."""
_WORST = {"snow": 0.008}
"""The worst run below the mean, at most; elsewhere 0.005."""
_BELOW_BOUND = {"snow": 0.015}
"""With a perturbation, below the bound of that plant, at most; elsewhere 0.01."""
_CAR_BELOW_BOUND = {"snow": 0.02, "dry to snow": 0.03}
"""Of the undisturbed car, below its bound, at most; elsewhere 0.01."""
_NOISE_LOSS = 0.005
_DRY_DISTANCE = 42.4
"""[m] from 30 m/s to standstill."""
_LEAST = {("dry", "load varies 5 %"): 0.94, ("dry", "load varies 10 %"): 0.90, ("dry", "gain fades 10 %/s"): 0.935}
"""Goals of their own."""
_DRY_ONLY = tuple(name for _, name in _LEAST)
_OVER_IDEAL = 1.04
"""Distance where the road changes over that of the ideal controller, at most."""
CAR_CHANGES = ("dry to snow",)
"""Roads that change under a car with four wheels."""
_NOTICED = 0.025
"""[s] by which a lock there may outlast the bound's, whose brakes know of the road: 10 ms for which evidence must last,
10 ms of delay of the brake, a sample."""
_CHANGE_LOCK = {"dry to snow": 0.12}
"""[s] longest lock there, at most: the brake takes 0.23 s to come down to what snow gives. Else below LOCK_TIME."""


def law_rows(
    cars: Sequence[str],
    law: str,
    seeds: int,
    surfaces: Sequence[str],
    cases: Sequence[str],
    judged: bool,
) -> list[Row]:
    """Make all stops; return a row per car, road and case.

    Args:
        cars: of CARS; none: all but the one with smart tyres.
        law: of abs_supervisor.
        seeds: stops of each row.
        surfaces: names of the roads; none: all.
        cases: names of the perturbations; none: all.
        judged: whether the limits apply; else the rows are for information.
    """
    return results_of(_make, chosen(cars, law, seeds, surfaces, cases, judged), law)


def _make(row: Callable[[], Row]) -> Row:
    return row()


def chosen(
    cars: Sequence[str], law: str, seeds: int, surfaces: Sequence[str], cases: Sequence[str], judged: bool
) -> list[Callable[[], Row]]:
    """Return what makes the rows; arguments as above."""
    found: list[Callable[[], Row]] = [
        partial(_made, car, law, seeds, road, case, judged)
        for car, road, case in _chosen(cars or _USUAL, surfaces, cases)
    ]
    drawn = range(FIRST_SEED, FIRST_SEED + seeds)
    if SMART_TYRES in cars:
        found += [partial(opinion_row, law, drawn, road) for road in TABLE_8_1 if not surfaces or road in surfaces]
    if RANDOM in cars:
        found += [
            partial(random_row, law, drawn, road, family)
            for road in TABLE_8_1
            for family in FAMILIES
            if (not surfaces or road in surfaces) and (not cases or family in cases)
        ]
    if SPLIT in (cars or _USUAL):
        found += [partial(split_row, law, drawn, *each) for each in chosen_splits(surfaces, cases)]
    return found


def _chosen(cars: Sequence[str], surfaces: Sequence[str], cases: Sequence[str]) -> list[tuple[str, str, Perturbation]]:
    return [
        (car, road, case)
        for car in cars
        if car not in (SPLIT, RANDOM, SMART_TYRES)
        for case in (NONE, *(PERTURBATIONS if car == CORNER_ALONE else CAR_PERTURBATIONS))
        for road in (*TABLE_8_1, *_changes(car, case))
        if (not surfaces or road in surfaces)
        and (not cases or case.name in cases)
        and (road == "dry" or case.name not in _DRY_ONLY)
        and (car == WHOLE_CAR or not (case.relaxation_length or case.hill))
    ]


def _changes(car: str, case: Perturbation) -> Sequence[str]:
    if case != NONE:
        return ()
    return CHANGES if car == CORNER_ALONE else CAR_CHANGES


def _made(car: str, law: str, seeds: int, road: str, case: Perturbation, judged: bool) -> Row:
    drawn = range(FIRST_SEED, FIRST_SEED + seeds)
    extra: Row = {}
    if car == CORNER_ALONE and road in CHANGES:
        return _changed(law, seeds, road, judged)
    if car == CORNER_ALONE:
        found, bound = law_stops(road, drawn, law, case), actuator_bound(road, case)
        limit = _least(road, case, bound)
        failures = _failures(found, limit) + (_undisturbed(road, found) if case == NONE else [])
        extra = {
            "ideal_controller": float(ideal_controller(road, case).utilisation[0]),
            "distance_over_ideal": float(found.distance.mean()) / _ideal(road, case),
        }
    else:
        setup = CarSetup(road, case)
        found, bound = car_stops(setup, drawn, law), car_bound(setup)
        limit = bound.utilisation - (_CAR_BELOW_BOUND if case == NONE else _BELOW_BOUND).get(road, 0.01)
        failures = _failures(found, limit, max(LOCK_TIME, bound.longest_lock + _NOTICED))
        extra = {"bound_longest_lock_s": bound.longest_lock} if road in CAR_CHANGES else {}
    return {
        "car": car,
        "surface": road,
        "case": case.name,
        "law": law,
        "seeds": seeds,
        "value": float(found.utilisation.mean()),
        "limit": limit if judged else None,
        "passed": not failures if judged else None,
        "failures": "; ".join(failures) if judged else "",
        "bound": bound.utilisation,
        "worst": float(found.utilisation.min()),
        "to_standstill": float(found.utilisation_to_rest.mean()),
        "bound_to_standstill": bound.utilisation_to_rest,
        "distance_m": float(found.distance.mean()),
        "bound_distance_m": bound.distance,
        "longest_lock_s": float(found.longest_lock.max()),
        "runs_with_lock": int((found.longest_lock >= LOCK_TIME).sum()),
        "commands_per_s": float(found.changes.mean()),
        **extra,
    }


def _changed(law: str, seeds: int, road: str, judged: bool) -> Row:
    """Return the row of a road that changes: its distance over the ideal controller's, and its locks."""
    found, best = law_stops(road, range(FIRST_SEED, FIRST_SEED + seeds), law, NONE), ideal_controller(road, NONE)
    ratio = float(found.distance.mean() / best.distance[0])
    lock, least_lock = float(found.longest_lock.max()), float(best.longest_lock[0])
    failures = [] if ratio <= _OVER_IDEAL else [f"distance {ratio:.4f} of the ideal controller's > {_OVER_IDEAL}"]
    longest = _CHANGE_LOCK.get(road, LOCK_TIME - DT)
    if not lock < longest + 0.5 * DT:
        failures.append(f"lock {lock:.3f} s > {longest:.3f} s")
    if not found.stopped.all():
        failures.append("does not come to rest")
    return {
        "car": CORNER_ALONE,
        "surface": road,
        "case": NONE.name,
        "law": law,
        "seeds": seeds,
        "value": ratio,
        "limit": _OVER_IDEAL if judged else None,
        "passed": not failures if judged else None,
        "failures": "; ".join(failures) if judged else "",
        "worst": float(found.distance.max() / best.distance[0]),
        "utilisation": float(found.utilisation.mean()),
        "ideal_controller": float(best.utilisation[0]),
        "distance_m": float(found.distance.mean()),
        "ideal_controller_distance_m": float(best.distance[0]),
        "longest_lock_s": lock,
        "ideal_controller_longest_lock_s": least_lock,
        "runs_with_lock": int((found.longest_lock >= LOCK_TIME).sum()),
        "commands_per_s": float(found.changes.mean()),
    }


def _ideal(road: str, case: Perturbation) -> float:
    mu_max = float(burckhardt.peak(surface(road))[1])
    return SPEED**2 / (2.0 * mu_max * case.corner(CORNER).gravity)


def _least(road: str, case: Perturbation, bound: ActuatorBound) -> float:
    """Return the least mean utilisation of a row."""
    if case == NONE:
        return _UTILISATION[road]
    if (road, case.name) in _LEAST:
        return _LEAST[road, case.name]
    if case.noise != 1.0:
        return _UTILISATION[road] - _NOISE_LOSS
    return bound.utilisation - _BELOW_BOUND.get(road, 0.01)


def _failures(found: PanicStops, limit: float, lock_limit: float = LOCK_TIME) -> list[str]:
    mean, lock = float(found.utilisation.mean()), float(found.longest_lock.max())
    failures = []
    if not mean >= limit:
        failures.append(f"utilisation {mean:.4f} < {limit:.4f}")
    if not lock < lock_limit:
        failures.append(f"lock {lock:.3f} s")
    if not found.stopped.all():
        failures.append("does not come to rest")
    return failures


def _undisturbed(road: str, found: PanicStops) -> list[str]:
    """Return what fails of what is asked for beside where nothing is disturbed."""
    below = float(found.utilisation.mean() - found.utilisation.min())
    failures = []
    spread = _WORST.get(road, 0.005)
    if not below <= spread:
        failures.append(f"worst run {below:.4f} below the mean > {spread}")
    distance = float(found.distance.mean())
    if road == "dry" and not distance <= _DRY_DISTANCE:
        failures.append(f"distance {distance:.2f} m > {_DRY_DISTANCE} m")
    return failures
