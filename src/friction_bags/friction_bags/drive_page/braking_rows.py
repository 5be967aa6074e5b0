"""Every braking of a run as a row of numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_bags.drive_page.brakings import all_brakings
from friction_bags.drive_page.drive_series import fits_of, vehicle_speed
from friction_bags.drive_page.recorded_run import RecordedRun

SLIP_COUNTS_ABOVE = 5.0
"""Speed [m/s] above which slips count for the largest one: below it, every wheel that stops locks."""


@dataclass(frozen=True)
class Peak:
    """An identified slip at the peak."""

    of: str
    """Wheel, wheels or vehicle."""
    lambda_max: float
    """[-]"""
    stddev: float
    """Its standard deviation [-]; NaN where unknown."""


@dataclass(frozen=True)
class BrakingRow:
    """One braking. SI units."""

    start: float
    end: float
    from_speed: float
    to_speed: float
    largest_slip: float
    """Largest valid slip of any wheel above 5 m/s [-]; NaN where none was valid."""
    slip_of: str
    """Wheel with the largest slip."""
    peaks: tuple[Peak, ...]
    """The last valid lambda_max of each wheel, and of the vehicle, in this braking."""

    @property
    def mean_deceleration(self) -> float:
        """[m/s^2]"""
        return (self.from_speed - self.to_speed) / (self.end - self.start)


def braking_rows(run: RecordedRun) -> list[BrakingRow]:
    """Return every braking of a run, by the speed of vehicle_speed, in the order of time."""
    if (speed := vehicle_speed(run)) is None:
        return []
    rows = []
    known = np.isfinite(speed[1])
    for start, end in all_brakings(*speed):
        before, after = np.interp((start, end), speed[0][known], speed[1][known])
        slip, wheel = _largest_slip(run, start, end)
        rows.append(BrakingRow(start, end, float(before), float(after), slip, wheel, _peaks(run, start, end)))
    return rows


def _largest_slip(run: RecordedRun, start: float, end: float) -> tuple[float, str]:
    found = [(np.nan, "")]
    for wheel in run.wheels:
        if (slip := run.get(f"{wheel}/slip")) is not None:
            inside = slice(*np.searchsorted(slip.time, (start, end), side="left"))
            counts = (slip["valid"][inside] > 0.0) & (slip["vehicle_speed"][inside] > SLIP_COUNTS_ABOVE)
            values = slip["slip"][inside][counts]
            found += [(float(np.max(values)), wheel)] if values.size else []
    return max(found[1:], default=found[0])


def _peaks(run: RecordedRun, start: float, end: float) -> tuple[Peak, ...]:
    found = []
    for fit in fits_of(run, ""):
        begin, stop = np.searchsorted(fit.curve.time, (start, end), side="left")
        valid = begin + np.flatnonzero(fit.curve["valid"][begin:stop] > 0.0)
        if valid.size:
            values = (float(fit.curve[name][valid[-1]]) for name in ("lambda_max", "lambda_max_stddev"))
            found.append(Peak(fit.label, *values))
    return tuple(found)
