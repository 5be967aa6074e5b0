"""Numbers of one run, and the worst of several."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from math import inf

import numpy as np
from friction_msgs.msg import BrakeCommand
from numpy.typing import NDArray

from benchmarks.protocol import DT
from benchmarks.run_lengths import run_lengths
from campaigns.faults.case import Case, Hit
from campaigns.faults.manoeuvre import ONSET, Manoeuvre
from campaigns.faults.record import Record
from campaigns.faults.reference import ABS_END, LOCK_SLIP, Reference
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

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
    samples_released: float
    """Number of DECREASE, all wheels."""
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
        samples_released=float(released.sum()),
        wrong_release=_longest(released & (slip < 0.5 * lambda_max)),
        largest_slip=float(np.where(fast, slip, 0.0).max()),
        longest_lock=_longest((slip > LOCK_SLIP) & late[:, np.newaxis]),
        named=record.named - ONSET - max(case.begin, 0.0) if record.named < inf else inf,
        none=float(record.time[none[0]] - before) if none.size and case.begin >= 0.0 else 0.0 if none.size else inf,
        healthy_lost=_longest(~record.acting[:, ~hit] & fast & begun[:, np.newaxis]) > _LOST,
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
