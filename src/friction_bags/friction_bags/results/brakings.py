"""Brakings of a drive, found by its speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
NO_CURVES: Array = np.empty(0)


def hardest_braking(time: Array, speed: Array) -> Span | None:
    """Find the braking with the hardest deceleration.

    Args:
        time: time of the samples [s], shape (n,), increasing; gaps are bridged.
        speed: vehicle speed [m/s], shape (n,); NaN where unknown.

    Returns:
        Begin and end [s] of the time around it in which the deceleration is above 3 m/s^2, or None where it never is.
    """
    at, _, deceleration = decelerations(time, speed)
    if at.size < 3:
        return None
    peak = float(at[np.argmax(deceleration)])
    spans = _above(at, deceleration, _HARD, last_known(time, speed)[0])
    return next((span for span in spans if span[0] <= peak <= span[1]), None)


def all_brakings(time: Array, speed: Array, curves: Array = NO_CURVES) -> list[Span]:
    """Find every braking: where the deceleration is above 1 m/s^2, and at least 1 m/s is lost or a curve was valid.

    Pauses below 0.5 s do not end a braking.

    Args:
        time: time of the samples [s], shape (n,), increasing; gaps are bridged.
        speed: vehicle speed [m/s], shape (n,); NaN where unknown.
        curves: times at which a friction curve was valid [s], shape (k,): those of short brakings on snow count.

    Returns:
        Begin and end [s] of each, in the order of time.
    """
    at, mean, deceleration = decelerations(time, speed)
    joined: list[Span] = []
    for begin, end in _above(at, deceleration, _GENTLE, last_known(time, speed)[0]):
        if joined and begin - joined[-1][1] < _JOINED:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((begin, end))
    lost = [-np.diff(np.interp(span, at, mean))[0] for span in joined]
    learned = [np.any((curves >= begin) & (curves <= end)) for begin, end in joined]
    return [span for span, each, curve in zip(joined, lost, learned, strict=True) if each >= _LOSS or curve]


def decelerations(time: Array, speed: Array) -> tuple[Array, Array, Array]:
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


def last_known(time: Array, speed: Array) -> tuple[float, float]:
    """Return time [s] and speed [m/s] of the last sample with a speed; NaN where there is none."""
    known = np.flatnonzero(np.isfinite(speed))
    return (float(time[known[-1]]), float(speed[known[-1]])) if known.size else (float("nan"), float("nan"))


def _above(at: Array, deceleration: Array, limit: float, last: float) -> list[Span]:
    """Return the spans in which the deceleration is above a limit, from the step before to the step after.

    One that the last step is part of lasts until the `last` sample [s].
    """
    edges = np.diff((deceleration > limit).astype(np.int8), prepend=0, append=0)
    begins, ends = np.flatnonzero(edges == 1) - 1, np.flatnonzero(edges == -1)
    pairs = zip(np.maximum(begins, 0), ends, strict=True)
    return [(float(at[begin]), float(at[end]) if end < at.size else last) for begin, end in pairs]
