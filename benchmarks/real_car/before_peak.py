"""mu_max while the brakes go up to the peak and have not reached it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.real_car.answers import follow
from benchmarks.rows import Row, at_least, at_most
from corner_sim.car.pressure_prescription import SlipCycle
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record

MEDIAN = {0.5: 30.0, 0.7: 12.0, 0.8: 12.0, 0.9: 7.0}
"""Largest median of |error| of mu_max [%] when a wheel uses this share of the friction there is."""
COVERAGE = 90.0
"""Least coverage of the 95 % interval [%]."""


@dataclass(frozen=True)
class Rise:
    """A rise of pressure to make, with a random car."""

    seed: int
    road: str
    family: str
    method: str


def make_rise(rise: Rise) -> list[tuple[float, float, bool]]:
    """Return share, relative error of mu_max and whether its interval holds, at each share and for each wheel.

    Valid or not: the number that a message has before the peak is one that a user takes.
    """
    car = random_car(rise.seed, rise.road, rise.family)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), rise.seed, duration=5.0)
    # the unevenness of the road moves the load, so that the friction used is not smooth; its first reach counts
    reached = {share: run.mu > share * run.mu_max for share in MEDIAN}
    samples = max(int(np.where(each.any(axis=0), each.argmax(axis=0), 0).max()) for each in reached.values()) + 1
    found = follow(rise.method, run, samples)
    results = []
    for share, each in reached.items():
        for wheel in range(4):
            if not each[:, wheel].any():
                continue
            k = int(each[:, wheel].argmax())
            error = found.mu_max[k, wheel] - run.mu_max[k, wheel]
            inside = abs(error) <= 1.96 * found.mu_max_stddev[k, wheel]
            results.append((share, error / run.mu_max[k, wheel], bool(inside)))
    return results


def rise_rows(family: str, results: Sequence[tuple[float, float, bool]]) -> list[Row]:
    """Rows of the tyres of a family; a wheel without any mu_max counts as one whose interval does not hold."""
    rows: list[Row] = []
    for share, limit in MEDIAN.items():
        error = np.array([error for at, error, _ in results if at == share])
        inside = [held for at, _, held in results if at == share]
        given = error[np.isfinite(error)]
        start = {"case": f"before the peak, {family}", "road": "all", "stops": len(error) // 4}
        median = 100.0 * float(np.median(np.abs(given))) if given.size else np.nan
        of = f"at {100 * share:.0f} % of it"
        coverage = 100.0 * float(np.mean(inside)) if inside else np.nan
        rows.append(start | {"quantity": f"coverage of mu_max {of} [%]"} | at_least(coverage, COVERAGE))
        rows.append(
            start
            | {"quantity": f"median |error| of mu_max {of} [%]"}
            | at_most(median, limit)
            | {"estimates": float(given.size)}
        )
    return rows
