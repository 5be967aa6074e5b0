"""Rows of the law on the identified curve: each road, each trouble, beside what its brake can do at best."""

from collections.abc import Callable, Sequence

from friction_evaluation.closed_loop.actuator_bound import ActuatorBound, actuator_bound
from friction_evaluation.closed_loop.law_stops import law_stops
from friction_evaluation.closed_loop.longest_lock import LOCK_TIME
from friction_evaluation.closed_loop.oracle import oracle
from friction_evaluation.closed_loop.panic_stop import PanicStops
from friction_evaluation.closed_loop.trouble import NONE, TROUBLES, Trouble
from friction_evaluation.protocol import CORNER, SPEED
from friction_evaluation.rows import Row
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface

FIRST_SEED = 30_000
"""Far from the seeds of the tuning, from 1000 on."""
_UTILISATION = {"dry": 0.953, "wet": 0.974, "cobblestone": 0.956, "snow": 0.988}
"""At least, where the car is known exactly, to 5 m/s."""
_WORST = {"snow": 0.008}
"""The worst run below the mean, at most; elsewhere 0.005."""
_BELOW_BOUND = {"snow": 0.015}
"""With a trouble, below the bound of that plant, at most; elsewhere 0.01."""
_NOISE_LOSS = 0.005
_DRY_DISTANCE = 42.4
"""[m] from 30 m/s to standstill."""
_LEAST = {("dry", "load varies 5 %"): 0.94, ("dry", "load varies 10 %"): 0.90, ("dry", "gain fades 10 %/s"): 0.935}
"""Goals of their own."""
_DRY_ONLY = tuple(name for _, name in _LEAST)


def law_rows(
    law: str, seeds: int, surfaces: Sequence[str], cases: Sequence[str], judged: bool, done: Callable[[], None]
) -> list[Row]:
    """Make all stops; return a row per road and case.

    Args:
        law: of abs_supervisor.
        seeds: stops of each row.
        surfaces: names of the roads; none: all.
        cases: names of the troubles; none: all.
        judged: whether the limits of the issue apply; else the rows are for information.
        done: called after each row.
    """
    return [_made(law, seeds, road, case, judged, done) for road, case in chosen(surfaces, cases)]


def chosen(surfaces: Sequence[str], cases: Sequence[str]) -> list[tuple[str, Trouble]]:
    """Return roads and cases of which rows are made."""
    return [
        (road, case)
        for case in (NONE, *TROUBLES)
        for road in TABLE_8_1
        if (not surfaces or road in surfaces)
        and (not cases or case.name in cases)
        and (road == "dry" or case.name not in _DRY_ONLY)
    ]


def _made(law: str, seeds: int, road: str, case: Trouble, judged: bool, done: Callable[[], None]) -> Row:
    found = law_stops(road, range(FIRST_SEED, FIRST_SEED + seeds), law, case)
    bound = actuator_bound(road, case)
    done()
    utilisation = float(found.utilisation.mean())
    limit = _least(road, case, bound)
    failures = [] if not judged else _failures(road, case, found, limit)
    return {
        "car": "corner",
        "surface": road,
        "case": case.name,
        "law": law,
        "seeds": seeds,
        "value": utilisation,
        "limit": limit if judged else None,
        "passed": not failures if judged else None,
        "failures": "; ".join(failures),
        "bound": bound.utilisation,
        "oracle": float(oracle(road, case).utilisation[0]),
        "worst": float(found.utilisation.min()),
        "to_standstill": float(found.utilisation_to_rest.mean()),
        "bound_to_standstill": bound.utilisation_to_rest,
        "distance_m": float(found.distance.mean()),
        "bound_distance_m": bound.distance,
        "distance_over_ideal": float(found.distance.mean()) / _ideal(road, case),
        "longest_lock_s": float(found.longest_lock.max()),
        "runs_with_lock": int((found.longest_lock >= LOCK_TIME).sum()),
        "commands_per_s": float(found.changes.mean()),
    }


def _ideal(road: str, case: Trouble) -> float:
    mu_max = float(burckhardt.peak(surface(road))[1])
    return SPEED**2 / (2.0 * mu_max * case.corner(CORNER).gravity)


def _least(road: str, case: Trouble, bound: ActuatorBound) -> float:
    """Return the least mean utilisation of a row."""
    if case is NONE:
        return _UTILISATION[road]
    if (road, case.name) in _LEAST:
        return _LEAST[road, case.name]
    if case.noise != 1.0:
        return _UTILISATION[road] - _NOISE_LOSS
    return bound.utilisation - _BELOW_BOUND.get(road, 0.01)


def _failures(road: str, case: Trouble, found: PanicStops, limit: float) -> list[str]:
    mean, worst = float(found.utilisation.mean()), float(found.utilisation.min())
    lock = float(found.longest_lock.max())
    failures = []
    if not mean >= limit:
        failures.append(f"utilisation {mean:.4f} < {limit:.4f}")
    if not lock < LOCK_TIME:
        failures.append(f"lock {lock:.3f} s")
    if not found.stopped.all():
        failures.append("does not come to rest")
    if case is NONE:
        spread = _WORST.get(road, 0.005)
        if not mean - worst <= spread:
            failures.append(f"worst run {mean - worst:.4f} below the mean > {spread}")
        distance = float(found.distance.mean())
        if road == "dry" and not distance <= _DRY_DISTANCE:
            failures.append(f"distance {distance:.2f} m > {_DRY_DISTANCE} m")
    return failures
