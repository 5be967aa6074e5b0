"""Measures of a faulty stop, its reference without ABS, and the limits that hold for every fault."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from math import inf
from typing import NamedTuple

import numpy as np
from friction_msgs.msg import BrakeCommand
from numpy.typing import NDArray

from abs_supervisor.parameters import SupervisorParameters
from benchmarks.protocol import DT
from benchmarks.runner import run_lengths
from campaigns.faults.case import CORNER, ONSET, Case, Hit, Manoeuvre
from campaigns.faults.catalogue import LOCKED_START, NO_FAULT, NOISE
from campaigns.faults.loop import Record
from corner_sim.plant import SAMPLE_TIME
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

_LONGEST = 600.0
"""[s]"""
ABS_END = 5.0
"""Utilisation and locks count above this speed [m/s], as in the part abs."""
LOCK_SLIP = 0.95


@dataclass(frozen=True)
class Reference:
    """From the onset of braking to standstill."""

    duration: float
    """[s]"""
    distance: float
    """[m]"""
    locks: bool
    """A wheel locks above 5 m/s, as at the rear at 0.9 of the front's peak torque."""
    beyond: tuple[bool, ...]
    """Which wheels pass their peak above 5 m/s, as those at the rear at 0.8: their brakes are not healthy."""
    torque: float
    """Of the wheel that is braked least [N m]."""


@cache
def without_abs(manoeuvre: Manoeuvre) -> Reference:
    """Return the numbers of the stop without ABS, the same for every seed and fault."""
    simulation = manoeuvre.simulation(0)
    samples = [simulation.sample]
    while simulation.end is None and simulation.time < _LONGEST:
        simulation.advance()
        samples.append(simulation.sample)
    lambda_max = float(burckhardt.peak(surface(manoeuvre.surface))[0])
    slip = np.array([each.slip for each in samples if each.speed > ABS_END])
    return Reference(
        duration=samples[-1].index * SAMPLE_TIME - ONSET,
        distance=samples[-1].distance - samples[round(ONSET / SAMPLE_TIME)].distance,
        locks=bool(np.any(slip > LOCK_SLIP)),
        beyond=tuple(np.any(slip > lambda_max, axis=0).tolist()),
        torque=float(samples[-1].brake_torque.min()),
    )


_SIGMAS = 3.0
"""Standard deviations from which on an estimate is wrong."""
_SLOW = 3.0
"""Below this speed [m/s] slip and the loss of ABS do not count."""
_LOST = 0.1
"""A healthy wheel whose supervisor does not act for longer [s] has lost its ABS."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Measures:
    """Of one run; with several, the worst of each. A larger number is the worse one, but in `utilisation`."""

    distance: float
    """[m] from the onset of braking; inf where the car did not stop."""
    distance_ratio: float
    """Over that without ABS."""
    duration_ratio: float
    """Over that without ABS."""
    longest_release: float
    """[s] of DECREASE at a stretch."""
    released: float
    """Share of the time with DECREASE, of the wheel that has most."""
    healthy_released: float
    """Number of DECREASE of the wheels that stay before their peak without ABS."""
    wrong_release: float
    """[s] longest DECREASE at a stretch at a slip below half of lambda_max."""
    largest_slip: float
    """[-] above 3 m/s."""
    longest_lock: float
    """[s] with a slip above 0.95, above 5 m/s and after the end of the fault."""
    named: float
    """[s] to the first reason or diagnostics above OK."""
    none: float
    """[s] from the last good message to NONE at all wheels that are hit; 0 where the fault was there before braking."""
    healthy_lost: bool
    """A wheel that the fault does not hit lost its ABS."""
    wrong_for: float
    """[s] longest time at a stretch, above 3 m/s, for which a slip is valid and off by more than three deviations."""
    utilisation: float
    """Mean of mu / mu_max down to 5 m/s."""


def measure(record: Record, case: Case, manoeuvre: Manoeuvre, reference: Reference) -> Measures:
    """Return the numbers of one run."""
    braking = record.time > ONSET
    onset = int(np.flatnonzero(~braking)[-1])
    distance = float(record.distance[-1] - record.distance[onset]) if record.stopped else inf
    duration = float(record.time[-1] - record.time[onset]) + DT if record.stopped else inf
    theta = surface(manoeuvre.surface)
    lambda_max, mu_max = (float(value) for value in burckhardt.peak(theta))
    slip = np.nan_to_num(record.slip)
    released = (record.command == BrakeCommand.DECREASE) & braking[:, np.newaxis]
    begun = record.time > ONSET + max(case.begin, 0.0) - 0.5 * DT
    fast = (braking & (record.speed > _SLOW))[:, np.newaxis]
    late = (record.speed > ABS_END) & (record.time > ONSET + (case.end if case.end < inf else 0.0))
    hit = _hit(case, record.slip.shape[1])
    used = burckhardt.friction(theta, slip)[braking & (record.speed > ABS_END)]
    none = np.flatnonzero(begun & (record.command[:, hit] == BrakeCommand.NONE).all(axis=1))
    before = ONSET + case.begin - DT
    return Measures(
        distance=distance,
        distance_ratio=distance / reference.distance,
        duration_ratio=duration / reference.duration,
        longest_release=_longest(released),
        released=float(released[braking].mean(axis=0).max()),
        healthy_released=float(released[:, ~np.array(reference.beyond)].sum()),
        wrong_release=_longest(released & (slip < 0.5 * lambda_max)),
        largest_slip=float(np.where(fast, slip, 0.0).max()),
        longest_lock=_longest((slip > LOCK_SLIP) & late[:, np.newaxis]),
        named=record.named - ONSET - max(case.begin, 0.0) if record.named < inf else inf,
        none=float(record.time[none[0]] - before) if none.size and case.begin >= 0.0 else 0.0 if none.size else inf,
        healthy_lost=_longest(~record.acting[:, ~hit] & fast & begun[:, np.newaxis]) > _LOST,
        wrong_for=_longest((np.abs(record.slip_error) > _SIGMAS) & fast),
        utilisation=float(used.mean() / mu_max),
    )


def worst(measures: Sequence[Measures]) -> Measures:
    """Return the worst of each number."""
    found = {}
    for each in fields(Measures):
        values = [getattr(run, each.name) for run in measures]
        found[each.name] = min(values) if each.name == "utilisation" else max(values)
    return Measures(**found)


def _hit(case: Case, wheels: int) -> Flags:
    hit = np.full(wheels, case.hit is Hit.ALL_WHEELS)
    hit[0] = case.hit is not Hit.NO_WHEEL
    return hit


def _longest(flags: Flags) -> float:
    """Longest time [s] that a column of flags, shape (k, n), stays true."""
    return int(run_lengths(flags).max(initial=0)) * DT


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
    else:
        yield Limit("distance ratio", found.distance_ratio, _PANIC if panic else _PARTIAL)
    if case in (NO_FAULT, *NOISE) and manoeuvre.demand < 1.0:
        yield Limit("DECREASE of a healthy wheel", found.healthy_released, 0.0)
    if case is NO_FAULT and panic:
        yield Limit("lock [s]", found.longest_lock, _LONGEST_LOCK)
        if manoeuvre.car == CORNER:
            yield Limit("utilisation lost", 1.0 - found.utilisation, 1.0 - _UTILISATION[manoeuvre.surface])
    yield Limit("valid and wrong slip [s]", found.wrong_for, case.wrong_for)
    if case is LOCKED_START:
        yield Limit("lock [s]", found.longest_lock, _RECOVERY)
    if not panic:
        yield Limit("release below half of lambda_max [s]", found.wrong_release, _WRONG_RELEASE)
    yield Limit("NONE after [s]", found.none, case.none_within + (case.none_later if panic else 0.0))
    yield Limit("named after [s]", found.named, case.named_within)
    yield Limit("over no fault", found.distance / no_fault.distance, case.stretch)
    if without_abs(manoeuvre).torque >= SupervisorParameters().braking_torque:
        yield Limit("healthy wheels without ABS", float(found.healthy_lost), 0.0)
