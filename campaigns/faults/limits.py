"""Limits of each row of the fault campaign."""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

from abs_supervisor.parameters import SupervisorParameters
from campaigns.faults.case import Case
from campaigns.faults.catalogue import LOCKED_START, NO_FAULT
from campaigns.faults.manoeuvre import CORNER, Manoeuvre
from campaigns.faults.measures import Measures
from campaigns.faults.reference import without_abs

_ORDINARY = 1.01
"""Distance and time without fault over those without ABS."""
_PARTIAL = 1.05
"""Distance with a fault over that without ABS, at a demand below the peak torque."""
_PANIC = 1.02
"""The same above it."""
_WRONG_RELEASE = 0.02
"""[s] longest release at a slip below half of the true lambda_max, at a demand below the peak torque."""
_UTILISATION = {"dry": 0.798, "wet": 0.850, "cobblestone": 0.742, "snow": 0.777}
"""Least of the corner in a panic stop without fault."""
_LONGEST_LOCK = 0.05
"""[s] in a panic stop without fault."""
_RECOVERY = 1.0
"""[s] within which a wheel that has locked turns again."""


class Limit(NamedTuple):
    """One limit of a row."""

    name: str
    value: float
    limit: float

    @property
    def passed(self) -> bool:
        """Is the value within the limit?"""
        return self.value <= self.limit + 1e-9

    def __str__(self) -> str:
        """Name, value and limit."""
        return f"{self.name} {self.value:.3g} > {self.limit:.3g}"


def limits(case: Case, manoeuvre: Manoeuvre, found: Measures, no_fault: Measures) -> list[Limit]:
    """Return the limits of a row, that of the distance first."""
    return [each for each in _all(case, manoeuvre, found, no_fault) if each.limit < inf]


def _all(case: Case, manoeuvre: Manoeuvre, found: Measures, no_fault: Measures) -> Iterator[Limit]:
    panic = manoeuvre.demand > 1.0 or without_abs(manoeuvre).locks
    if case is NO_FAULT and not panic:
        yield Limit("distance ratio", found.distance_ratio, _ORDINARY)
        yield Limit("duration ratio", found.duration_ratio, _ORDINARY)
        yield Limit("DECREASE", found.samples_released, 0.0)
    else:
        yield Limit("distance ratio", found.distance_ratio, _PANIC if panic else _PARTIAL)
    if case is NO_FAULT and panic:
        yield Limit("lock [s]", found.longest_lock, _LONGEST_LOCK)
        if manoeuvre.car == CORNER:
            yield Limit("utilisation lost", 1.0 - found.utilisation, 1.0 - _UTILISATION[manoeuvre.surface])
    if case is LOCKED_START:
        yield Limit("lock [s]", found.longest_lock, _RECOVERY)
    if not panic:
        yield Limit("release below half of lambda_max [s]", found.wrong_release, _WRONG_RELEASE)
    yield Limit("NONE after [s]", found.none, case.none_within + (case.none_later if panic else 0.0))
    yield Limit("named after [s]", found.named, case.named_within)
    yield Limit("over no fault", found.distance / no_fault.distance, case.stretch)
    if without_abs(manoeuvre).torque >= SupervisorParameters().braking_torque:
        yield Limit("healthy wheels without ABS", float(found.healthy_lost), 0.0)
