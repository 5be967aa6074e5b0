"""Rows of the tables `brakings` and `bounds` from a processed bag."""

from __future__ import annotations

from math import isfinite, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bags.results.braking_rows import CAR, BrakingRow, Part, braking_rows, most_certain
from friction_bags.results.places import Places
from friction_bags.results.recorded_run import RecordedRun
from friction_fleet.places import NOWHERE, cells_at
from friction_grip.road_memory import PROOF_SIGMAS
from vehicle_models.nanoseconds import NANOSECONDS

Row = dict[str, Any]
_PARTS = ("vehicle", "front", "rear")
_MEAN = 0.2
"""Time of which friction in use is the mean [s]."""
_QUANTITIES = ("mu_used", "mu_used_stddev", "lambda_max", "lambda_max_stddev", "valid")


def rows_of_brakings(run: RecordedRun, places: Places, key: str, vehicle: str) -> list[Row]:
    """Return a row for the car in each braking, and one for each axle or wheel that differs.

    Its place is where the peak was known best, else where the braking began. The car's mu_max is the median of those of
    its wheels, each the most certain, with the widest deviation: as wheels of one car err together.
    """
    made = []
    for braking in braking_rows(run):
        peak, stddev, at = _peak(run, braking)
        stamp = run.start + round((at if isfinite(at) else braking.start) * NANOSECONDS)
        latitude, longitude = places.at(np.array([stamp]))[:, 0].tolist()
        common = {
            "bag": key,
            "vehicle": vehicle,
            "start": _microseconds(run.start + round(braking.start * NANOSECONDS)),
            "duration": braking.end - braking.start,
            "stamp": _microseconds(stamp),
            "latitude": _known(latitude),
            "longitude": _known(longitude),
            "cell": int(cells_at(places, np.array([stamp]))[0]) or None,
            "from_speed": braking.from_speed,
            "to_speed": braking.to_speed,
            "deceleration": _known(braking.mean_deceleration),
            "largest_slip": _known(braking.largest_slip),
        }
        for part in braking.parts:
            of_part = (peak, stddev, at) if part.of == CAR else (part.mu_max, part.mu_max_stddev, part.valid_at)
            made.append({**common, **_of_part(part, *of_part[:2]), "contradicted": _contradicted(run, *of_part)})
    return made


def rows_of_bounds(run: RecordedRun, places: Places, key: str, vehicle: str) -> list[Row]:
    """Return a row for each pass through a cell: the largest friction that was used, of the car or an axle.

    The largest is that with the highest lower end. mu_proven and mu_lower are the largest of the pass.
    """
    grip = run.get("grip")
    if grip is None:
        return []
    stamps = run.start + np.round(grip.time * NANOSECONDS).astype(np.int64)
    cells = cells_at(places, stamps)
    used = np.array([grip[f"{part}.mu_used"] for part in _PARTS])
    stddev = np.array([grip[f"{part}.mu_used_stddev"] for part in _PARTS])
    proof = np.where(np.isfinite(used + stddev), used - PROOF_SIGMAS * stddev, -np.inf)
    borders = np.flatnonzero(np.diff(cells)) + 1
    made = []
    for visit in np.split(np.arange(cells.size), borders):
        if not visit.size:
            continue
        part, sample = np.unravel_index(int(np.argmax(proof[:, visit])), (len(_PARTS), visit.size))
        best = visit[sample]
        if proof[part, best] <= 0.0:
            continue
        made.append(
            {
                "bag": key,
                "vehicle": vehicle,
                "stamp": _microseconds(int(stamps[best])),
                "cell": None if cells[best] == NOWHERE else int(cells[best]),
                "mu_used": float(used[part, best]),
                "mu_used_stddev": float(stddev[part, best]),
                "mu_proven": _largest(grip["mu_proven"][visit]),
                "mu_lower": _largest(grip["mu_lower"][visit]),
            }
        )
    return made


def _peak(run: RecordedRun, braking: BrakingRow) -> tuple[float, float, float]:
    """Return mu_max, its deviation and its time [s] in a braking; NaN where no wheel knows it."""
    known = []
    for wheel in (*run.wheels, "vehicle"):
        curve = run.get(f"{wheel}/friction_curve")
        row = None if curve is None else most_certain(curve, braking.start, braking.end)
        if curve is not None and row is not None and isfinite(curve["mu_max_stddev"][row]):
            known.append((curve["mu_max"][row], curve["mu_max_stddev"][row], curve.time[row]))
    if not known:
        return nan, nan, nan
    table = np.array(known)
    return float(np.median(table[:, 0])), float(table[:, 1].max()), float(table[:, 2].max())


def _of_part(part: Part, peak: float, stddev: float) -> Row:
    return {
        "of": part.of,
        **{name: _known(getattr(part, name)) for name in _QUANTITIES},
        "mu_max": _known(peak),
        "mu_max_stddev": _known(stddev),
        "reason": part.reason,
    }


def _contradicted(run: RecordedRun, peak: float, stddev: float, at: float) -> bool:
    """Return whether the car used more than a peak while the peak was known: before, the road may have been another."""
    grip = run.get("grip")
    if grip is None:
        return False
    then = (grip.time > at - _MEAN) & (grip.time <= at)
    used, of_used = grip["vehicle.mu_used"][then], grip["vehicle.mu_used_stddev"][then]
    return bool(np.any(used - peak > PROOF_SIGMAS * np.hypot(of_used, stddev)))


def _microseconds(stamp: int) -> int:
    return stamp // 1000


def _largest(values: NDArray[np.float64]) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None


def _known(value: float) -> float | None:
    return value if isfinite(value) else None
