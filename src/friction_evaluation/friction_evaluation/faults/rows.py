"""Rows of the campaign: a manoeuvre and a case, over the seeds."""

from collections.abc import Callable, Sequence
from typing import Any

from friction_evaluation.faults.case import Case
from friction_evaluation.faults.catalogue import NO_FAULT
from friction_evaluation.faults.limits import limits
from friction_evaluation.faults.loop import Loop
from friction_evaluation.faults.manoeuvre import Manoeuvre
from friction_evaluation.faults.measures import Measures, measure, worst
from friction_evaluation.faults.reference import without_abs
from friction_evaluation.rows import Row

_FIRST_SEED = 40_000
"""Far from the seeds of the tuning and of the other parts."""


def rows_of(manoeuvre: Manoeuvre, cases: Sequence[Case], seeds: int, law: str, done: Callable[[], None]) -> list[Row]:
    """Make all stops of a manoeuvre under a law; return a row per case.

    The stop without fault is made once for all of them. `done` is called after each row.
    """
    no_fault, quiet = _stops(manoeuvre, NO_FAULT, seeds, law)
    rows: list[Row] = []
    for case in cases:
        found, said = (no_fault, quiet) if case is NO_FAULT else _stops(manoeuvre, case, seeds, law)
        rows.append(_row(manoeuvre, case, seeds, found, no_fault, said))
        done()
    return rows


def _stops(manoeuvre: Manoeuvre, case: Case, seeds: int, law: str) -> tuple[Measures, str]:
    """Return the worst numbers over the seeds, and what diagnostics said first in the first run."""
    reference = without_abs(manoeuvre)
    longest = 1.3 * reference.duration + 2.0
    records = [Loop(manoeuvre, case, seed, law).run(longest) for seed in range(_FIRST_SEED, _FIRST_SEED + seeds)]
    return worst([measure(record, case, manoeuvre, reference) for record in records]), records[0].said


def _row(manoeuvre: Manoeuvre, case: Case, seeds: int, found: Measures, no_fault: Measures, said: str) -> Row:
    reference = without_abs(manoeuvre)
    judged = limits(case, manoeuvre, found, no_fault)
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
        "distance_no_fault_m": no_fault.distance,
        "longest_release_s": found.longest_release,
        "released_share": found.released,
        "release_below_half_lambda_max_s": found.wrong_release,
        "largest_slip": found.largest_slip,
        "utilisation": found.utilisation,
        "none_after_s": found.none if case.none_within < 1e9 else None,
        "named_after_s": found.named,
        "healthy_lost_abs": found.healthy_lost,
        "diagnostics": said,
    }
    return row
