"""Evidence of many drives through the town that is drawn, not estimated: for the map alone, in seconds.

A pass uses friction as drivers do who do not know the road, and never more than the tyres have. Where a braking asks
for more than there is, the peak is passed, and a curve may become valid.
"""

from __future__ import annotations

import numpy as np

from friction_fleet.cells import cell_of
from friction_fleet.evidence import Evidence
from friction_fleet.simulation.drives import BETWEEN_TYRES, HARD
from friction_fleet.simulation.town import START, Town, along, place
from friction_grip.road_memory import PROOF_SIGMAS

_STEP = 5.0
"""Distance of the points of a way [m]."""
_SPEED = 14.0
"""[m/s]"""
_BRAKINGS, _BRAKING = 350.0, 40.0
"""Mean distance of brakings and length of one [m]."""
_USE = 0.05
"""Mean friction used between brakings."""
_BIAS, _STDDEV = 0.02, 0.04
"""Error of the friction used, of a drive as it comes from the accelerometer, and the deviation that is stated."""
VALID = 0.5
"""Share of the passed peaks that become valid curves."""
_FIT_ERROR = 0.05
"""Their deviation, relative, as they state it."""


def drawn_evidence(seed: int, cars: int, drives: int, seconds: float, valid: float = VALID) -> list[Evidence]:
    """Draw the evidence of a fleet.

    Args:
        seed: same seed, same town and evidence.
        cars: number of cars, each with tyres of its own.
        drives: of each car, over a day.
        seconds: length of a drive [s].
        valid: share of the passed peaks that become valid curves.
    """
    town, found = Town(seed), []
    rng = np.random.default_rng([seed, 25])
    tyres = np.exp(rng.normal(0.0, BETWEEN_TYRES, cars))
    for car, tyre in enumerate(tyres.tolist()):
        for _ in range(drives):
            found += _drive(town, rng, f"car{car:03d}", tyre, seconds, valid)
    return sorted(found, key=lambda each: (each.stamp, each.cell, each.vehicle))


def _drive(
    town: Town, rng: np.random.Generator, vehicle: str, tyre: float, seconds: float, valid: float
) -> list[Evidence]:
    bias = _BIAS * float(rng.normal())
    hour, length = float(rng.uniform(0.0, 23.9)), _SPEED * seconds
    way = town.route(rng, length)
    uses: dict[int, tuple[float, float]] = {}
    fits: dict[int, Evidence] = {}
    asked, until, next_braking, passed = 0.0, 0.0, float(rng.exponential(_BRAKINGS)), False
    for distance in np.arange(0.0, length, _STEP).tolist():
        if distance >= next_braking:
            hard = rng.uniform() < HARD
            asked = 2.0 if hard else 0.05 + 0.45 * float(rng.uniform()) ** 2
            until, passed = distance + _BRAKING, False
            next_braking = until + float(rng.exponential(_BRAKINGS))
        demand = asked if distance < until else float(rng.exponential(_USE))
        street, offset = along(way, distance)
        friction = tyre * town.road(street, offset, hour + distance / _SPEED / 3600.0)[1]
        cell, stamp = cell_of(*place(street, offset)), START + 3600.0 * hour + distance / _SPEED
        used = max(min(demand, friction) + bias, 0.0)
        if used > uses.get(cell, (0.0, 0.0))[0]:
            uses[cell] = used, stamp
        if distance < until and demand > friction and not passed:
            passed = True
            if rng.uniform() < valid:
                mu = friction * float(np.exp(_FIT_ERROR * rng.normal()))
                fits[cell] = Evidence(cell, stamp, vehicle, mu, _FIT_ERROR * mu, True)
    bounds = [
        Evidence(cell, stamp, vehicle, used, _STDDEV, False)
        for cell, (used, stamp) in uses.items()
        if used > PROOF_SIGMAS * _STDDEV and cell not in fits
    ]
    return [*fits.values(), *bounds]
