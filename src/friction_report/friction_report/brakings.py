"""Brakings of a drive, found by its speed alone, and each as a row of numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_report.drive_series import fits_of, vehicle_speed
from friction_report.recorded_run import RecordedRun

Array = NDArray[np.float64]
Span = tuple[float, float]
"""Begin and end [s]."""

_STEP = 0.1
"""Time [s] over which the deceleration is taken."""
_HARD = 3.0
"""Deceleration above which a braking counts as hard [m/s^2]."""
_GENTLE = 1.0
"""Deceleration above which a car is braked rather than coasting [m/s^2]; on snow no braking reaches 3."""
_JOINED = 0.5
"""Brakings with less time [s] between them are one: a supervisor releases for no longer."""
_LOSS = 1.0
"""Least loss of speed [m/s] of a braking: what is less is a bump or noise."""
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


def hardest_braking(time: Array, speed: Array) -> Span | None:
    """Find the braking with the hardest deceleration.

    Args:
        time: time of the samples [s], shape (n,), increasing; gaps are bridged.
        speed: vehicle speed [m/s], shape (n,); NaN where unknown.

    Returns:
        Begin and end [s] of the time around it in which the deceleration is above 3 m/s^2, or None where it never is.
    """
    at, _, deceleration = _decelerations(time, speed)
    if at.size < 3:
        return None
    peak = float(at[np.argmax(deceleration)])
    return next((span for span in _above(at, deceleration, _HARD) if span[0] <= peak <= span[1]), None)


def all_brakings(time: Array, speed: Array) -> list[Span]:
    """Find every braking: where the deceleration is above 1 m/s^2 and at least 1 m/s is lost.

    Pauses below 0.5 s do not end a braking.

    Args:
        time: time of the samples [s], shape (n,), increasing; gaps are bridged.
        speed: vehicle speed [m/s], shape (n,); NaN where unknown.

    Returns:
        Begin and end [s] of each, in the order of time.
    """
    at, mean, deceleration = _decelerations(time, speed)
    joined: list[Span] = []
    for begin, end in _above(at, deceleration, _GENTLE):
        if joined and begin - joined[-1][1] < _JOINED:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((begin, end))
    lost = [-np.diff(np.interp(span, at, mean))[0] for span in joined]
    return [span for span, each in zip(joined, lost, strict=True) if each >= _LOSS]


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


def _decelerations(time: Array, speed: Array) -> tuple[Array, Array, Array]:
    """Return times [s], mean speeds [m/s] and decelerations [m/s^2] of the steps that hold a sample, shapes (k,)."""
    known = np.isfinite(speed)
    if np.count_nonzero(known) < 2:
        return (np.empty(0),) * 3
    t, v = time[known], speed[known]
    firsts = np.flatnonzero(np.diff(np.floor((t - t[0]) / _STEP), prepend=-1.0))
    counts = np.diff(firsts, append=t.size)
    at, mean = np.add.reduceat(t, firsts) / counts, np.add.reduceat(v, firsts) / counts
    if at.size < 3:
        return (np.empty(0),) * 3
    return at, mean, -np.gradient(mean, at)


def _above(at: Array, deceleration: Array, limit: float) -> list[Span]:
    """Return the spans in which the deceleration is above a limit, from the step before to the step after."""
    edges = np.diff((deceleration > limit).astype(np.int8), prepend=0, append=0)
    begins, ends = np.flatnonzero(edges == 1) - 1, np.flatnonzero(edges == -1)
    last = at.size - 1
    pairs = zip(np.maximum(begins, 0), np.minimum(ends, last), strict=True)
    return [(float(at[begin]), float(at[end])) for begin, end in pairs]


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
