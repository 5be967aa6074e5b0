"""Fault campaign: rows of manoeuvre and case over the seeds, with their limits."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from os import times
from typing import Any

from rich.progress import Progress

from abs_supervisor.parameters import CURVE, SLOPE_SIGN
from benchmarks.engine import results_of
from benchmarks.runner import Row
from campaigns.faults.case import Case, Manoeuvre
from campaigns.faults.catalogue import CASES, NO_FAULT, Plan, quick, whole
from campaigns.faults.loop import Loop
from campaigns.faults.measures import Measures, limits, measure, without_abs, worst
from friction_parameters.command_line import count, positive

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
    loop = Loop(manoeuvre, case, stop.seed, stop.law)
    record = loop.run(1.3 * reference.duration + 2.0)
    return measure(record, case, manoeuvre, reference), record.said


def rows(plan: Plan, seeds: int, law: str) -> list[Row]:
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
    made = iter(results_of(make_stop, stops, "stops"))
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
        "wrong_slip_s": found.wrong_for,
        "utilisation": found.utilisation,
        "none_after_s": found.none if case.none_within < 1e9 else None,
        "named_after_s": found.named,
        "healthy_lost_abs": found.healthy_lost,
        "diagnostics": stops.said,
    }
    return row


LAWS = (SLOPE_SIGN, CURVE)
"""What may ask for a release: the sign of the slope, section 8.2.2, or the slip control on the identified curve."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--seeds", type=count, default=1, help="seeds of sensor noise and fault for each row")
    parser.add_argument("--law", choices=LAWS, default=LAWS[0], help="what asks for the release")
    parser.add_argument(
        "--quick", action="store_true", help="the fixed subset of docs/faults.md: at most 8 CPU minutes"
    )
    parser.add_argument(
        "--live", type=int, metavar="TRIALS", help="instead: fail-safe times over DDS, trials per input"
    )
    for name in ("car", "surface", "fault"):
        parser.add_argument(f"--{name}", action="append", help="only these rows; repeatable")
    parser.add_argument("--demand", type=positive, action="append", help="only these rows; repeatable")


def run(options: argparse.Namespace) -> list[Row]:
    """Make all stops; return a row per car, surface, demand and fault."""
    if options.live is not None:
        return _live(options.live)
    found = rows(_chosen(options), options.seeds, options.law)
    print(f"{len(found)} rows, {sum(times()[:4]):.0f} s of CPU")
    return found


def _live(trials: int) -> list[Row]:
    # here, because the campaign itself needs no middleware
    from campaigns.faults.live import LIVE_ROWS, fail_safe_rows

    with Progress() as progress:
        task = progress.add_task("fail-safe times", total=LIVE_ROWS * trials)
        return fail_safe_rows(trials, lambda: progress.advance(task))


def _chosen(options: argparse.Namespace) -> Plan:
    plan = []
    for manoeuvre, cases in quick() if options.quick else whole():
        chosen = [case for case in cases if not options.fault or case.name in options.fault]
        if (
            (not options.car or manoeuvre.car in options.car)
            and (not options.surface or manoeuvre.surface in options.surface)
            and (not options.demand or manoeuvre.demand in options.demand)
            and chosen
        ):
            plan.append((manoeuvre, chosen))
    return plan
