"""Rows of the campaign: a manoeuvre and a case, over the seeds."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchmarks.pool import in_processes
from benchmarks.rows import Row
from campaigns.faults.case import Case
from campaigns.faults.catalogue import CASES, NO_FAULT
from campaigns.faults.limits import limits
from campaigns.faults.loop import Loop
from campaigns.faults.manoeuvre import Manoeuvre
from campaigns.faults.measures import Measures, measure, worst
from campaigns.faults.plan import Plan
from campaigns.faults.reference import samples_without_abs, without_abs

_FIRST_SEED = 40_000
"""Far from the seeds of the tuning and of the other parts."""


@dataclass(frozen=True)
class Stop:
    """What a process needs to make one stop."""

    manoeuvre: Manoeuvre
    fault: str
    seed: int
    law: str


@dataclass(frozen=True)
class _Stops:
    """The worst numbers over the seeds, and what diagnostics said first in the first run."""

    found: Measures
    said: str


def make_stop(stop: Stop) -> tuple[Measures, str]:
    """Return the numbers of a stop, and what diagnostics said first."""
    manoeuvre, case = stop.manoeuvre, CASES[stop.fault]
    reference = without_abs(manoeuvre)
    loop = Loop(manoeuvre, case, stop.seed, stop.law, samples_without_abs(manoeuvre))
    record = loop.run(1.3 * reference.duration + 2.0)
    return measure(record, case, manoeuvre, reference), record.said


def rows(plan: Plan, seeds: int, law: str, processes: int) -> list[Row]:
    """Make all stops of a plan under a law; return a row per manoeuvre and case.

    The stop without fault is made once for all cases of a manoeuvre.
    """
    chosen = [(manoeuvre, list(dict.fromkeys((NO_FAULT, *cases)))) for manoeuvre, cases in plan]
    stops = [
        Stop(manoeuvre, case.name, _FIRST_SEED + seed, law)
        for manoeuvre, cases in chosen
        for case in cases
        for seed in range(seeds)
    ]
    made = iter(in_processes(make_stop, stops, "stops", processes))
    found: list[Row] = []
    for (manoeuvre, made_cases), (_, cases) in zip(chosen, plan, strict=True):
        of_case = {case: _over_seeds(made, seeds) for case in made_cases}
        found += [_row(manoeuvre, case, seeds, of_case[case], of_case[NO_FAULT]) for case in cases]
    return found


def _over_seeds(made: Iterator[tuple[Measures, str]], seeds: int) -> _Stops:
    runs = [next(made) for _ in range(seeds)]
    return _Stops(worst([found for found, _ in runs]), runs[0][1])


def _row(manoeuvre: Manoeuvre, case: Case, seeds: int, stops: _Stops, no_fault: _Stops) -> Row:
    reference, found = without_abs(manoeuvre), stops.found
    judged = limits(case, manoeuvre, found, no_fault.found)
    failures = [str(each) for each in judged if not each.passed]
    row: dict[str, Any] = {
        "car": manoeuvre.car,
        "surface": manoeuvre.surface,
        "demand": manoeuvre.demand,
        "fault": case.name,
        "seeds": seeds,
        "value": judged[0].value,
        "limit": judged[0].limit,
        "passed": not failures,
        "failures": "; ".join(failures),
        "distance_m": found.distance,
        "distance_no_abs_m": reference.distance,
        "distance_no_fault_m": no_fault.found.distance,
        "longest_release_s": found.longest_release,
        "released_share": found.released,
        "release_below_half_lambda_max_s": found.wrong_release,
        "largest_slip": found.largest_slip,
        "utilisation": found.utilisation,
        "none_after_s": found.none if case.none_within < 1e9 else None,
        "named_after_s": found.named,
        "healthy_lost_abs": found.healthy_lost,
        "diagnostics": stops.said,
    }
    return row
