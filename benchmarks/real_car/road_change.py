"""Roads that one curve does not describe: a change while braking, a split road; and mu_max before the peak.

An estimate may have no answer there; it may not have a wrong one. A wheel's truth is the peak of its tyre on the road
that it is on. What is valid up to GRACE after the last wheel has come to the new road is not judged: the wheels are on
two roads, and no estimator knows at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.real_car.stops import follow
from benchmarks.runner import Row, at_least, at_most, not_judged
from corner_sim.car.car import Car
from corner_sim.car.driving import SlipCycle, Surroundings
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import record
from corner_sim.car.tyres import TYRES, Tyre

CHANGES = (("dry", "snow"), ("snow", "dry"), ("dry", "wet"), ("wet", "dry"))
"""Roads before and after."""
SPLITS = (("dry", "snow"), ("wet", "snow"), ("dry", "wet"))
"""Roads of the left and of the right wheels."""
BRAKED = 18.0
"""Way of the front axle on the first road after the begin of braking [m]: its curve is valid by then."""
GRACE = 0.1
"""[s]"""
AFTER = 1.5
"""Time after the begin of braking to which a stop is followed, or after the change [s]."""
COVERAGE = 90.0
"""Least share of the valid messages whose 95 % intervals hold the truth [%]."""


@dataclass(frozen=True)
class TwoRoads:
    """A stop on two roads to make, with a random car."""

    seed: int
    roads: tuple[str, str]
    split: bool
    """Left and right; else one after the other."""
    family: str


@dataclass(frozen=True)
class TwoRoadsResult:
    """What was valid, of all wheels."""

    before: int
    """Valid messages before the change."""
    messages: int
    """Valid messages that are judged."""
    lambda_inside: int
    mu_inside: int
    last_old: float
    """From the change of the last wheel to the last valid message whose interval of mu_max misses the new road [s]."""
    regained: float
    """From the change to the first valid message that holds the new road [s]; infinite where there is none."""


class _Roads:
    """Puts each wheel on the road where it is, and notes which tyre each wheel has."""

    def __init__(self, first: Tyre, second: Tyre, wheelbase: float, begin: float) -> None:
        self._first, self._second, self._wheelbase, self._begin = first, second, wheelbase, begin
        self._braked_from: float | None = None
        self.changed_at = np.full(4, np.inf)

    def __call__(self, time: float, car: Car) -> Surroundings:
        if self._braked_from is None and time >= self._begin:
            self._braked_from = car.distance
        for wheel, behind in enumerate((0.0, 0.0, self._wheelbase, self._wheelbase)):
            reached = self._braked_from is not None and car.distance - self._braked_from - behind > BRAKED
            if reached and np.isinf(self.changed_at[wheel]):
                self.changed_at[wheel] = time
                car.tyres[wheel] = self._second
        return Surroundings()


def make_two_roads(job: TwoRoads) -> TwoRoadsResult:
    """Drive, estimate and compare."""
    drawn = random_car(job.seed, job.roads[0], job.family)
    first, second = (TYRES[job.family][road] for road in job.roads)
    begin = drawn.cycling.start
    if job.split:
        car = replace(drawn.parameters, tyres=(first, second, first, second))
        run = record(car, SlipCycle(car, drawn.cycling), job.seed, duration=begin + AFTER)
        changed = np.full(4, -np.inf)
        truth = np.broadcast_to([tyre.peak for tyre in car.tyres], (len(run.time), 4, 2))
    else:
        car, roads = drawn.parameters, _Roads(first, second, drawn.parameters.wheelbase, begin)
        run = record(car, SlipCycle(car, drawn.cycling), job.seed, duration=begin + AFTER + 1.0, surroundings=roads)
        changed = roads.changed_at
        new = run.time[:, np.newaxis] > changed
        truth = np.where(new[:, :, np.newaxis], second.peak, first.peak)
    found = follow(run, len(run.time))
    valid = found.valid == 1.0
    lambda_inside = np.abs(found.lambda_max - truth[:, :, 0]) <= 1.96 * found.lambda_max_stddev
    mu_inside = np.abs(found.mu_max - truth[:, :, 1]) <= 1.96 * found.mu_max_stddev
    last = float(changed.max())
    since = run.time - last
    judged = valid & ((since > GRACE) | (run.time < changed.min()))[:, np.newaxis]
    wrong = (valid & ~mu_inside & (since > 0.0)[:, np.newaxis]).any(axis=1)
    right = (valid & mu_inside & lambda_inside & (since > 0.0)[:, np.newaxis]).any(axis=1)
    return TwoRoadsResult(
        before=int((valid & (run.time < changed.min())[:, np.newaxis]).sum()),
        messages=int(judged.sum()),
        lambda_inside=int((judged & lambda_inside).sum()),
        mu_inside=int((judged & mu_inside).sum()),
        last_old=float(since[wrong].max()) if wrong.any() else 0.0,
        regained=float(since[right].min()) if right.any() else np.inf,
    )


def two_roads_rows(roads: tuple[str, str], split: bool, results: Sequence[TwoRoadsResult]) -> list[Row]:
    """Rows of stops on two roads; without any valid message nothing is wrong."""
    start = {
        "case": "split road" if split else "road change",
        "road": f"{roads[0]} | {roads[1]}" if split else f"{roads[0]} to {roads[1]}",
        "stops": len(results),
    }
    messages = sum(result.messages for result in results)
    rows: list[Row] = []
    for name, inside in (
        ("lambda_max", sum(result.lambda_inside for result in results)),
        ("mu_max", sum(result.mu_inside for result in results)),
    ):
        share = 100.0 * inside / messages if messages else 100.0
        rows.append(
            start
            | {"quantity": f"coverage of {name}, all valid messages [%]"}
            | at_least(share, COVERAGE)
            | {"estimates": float(messages)}
        )
    if split:
        return rows
    old = 100.0 * float(np.mean([result.last_old > GRACE for result in results]))
    regained = np.array([result.regained for result in results])
    rows.append(start | {"quantity": f"valid and wrong later than {GRACE} s [% of stops]"} | at_most(old, 10.0))
    rows.append(
        start
        | {"quantity": "valid on the new road [% of stops]"}
        | not_judged(100.0 * float(np.isfinite(regained).mean()))
        | {"median_ms": 1e3 * float(np.median(regained))}
    )
    valid_before = 100.0 * float(np.mean([result.before > 0 for result in results]))
    rows.append(start | {"quantity": "valid before the change [% of stops]"} | not_judged(valid_before))
    return rows


MEDIAN = {0.5: 30.0, 0.7: 12.0, 0.8: 12.0, 0.9: 7.0}
"""Largest median of |error| of mu_max [%] when a wheel uses this share of the friction there is."""


@dataclass(frozen=True)
class Rise:
    """A rise of pressure to make, with a random car."""

    seed: int
    road: str
    family: str


def make_rise(rise: Rise) -> list[tuple[float, float, bool]]:
    """Return share, relative error of mu_max and whether its interval holds, at each share and for each wheel.

    Valid or not: the number that a message has before the peak is one that a user takes.
    """
    car = random_car(rise.seed, rise.road, rise.family)
    run = record(car.parameters, SlipCycle(car.parameters, car.cycling), rise.seed, duration=5.0)
    # the unevenness of the road moves the load, so that the friction used is not smooth; its first reach counts
    reached = {share: run.mu > share * run.mu_max for share in MEDIAN}
    samples = max(int(np.where(each.any(axis=0), each.argmax(axis=0), 0).max()) for each in reached.values()) + 1
    found = follow(run, samples)
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
