"""Decimation that keeps the minimum and maximum of every interval."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

_AROUND = 0.5
"""Time [s] before and after a braking that is shown as finely as the braking."""


def bucket_edges(start: float, end: float, brakings: Sequence[tuple[float, float]], coarse: int, fine: int) -> Array:
    """Divide a drive into buckets: equal ones over all of it, and as fine as the number allows in brakings.

    Args:
        start: begin of the drive [s].
        end: its end [s].
        brakings: begin and end [s] of each.
        coarse: number of buckets over the whole drive.
        fine: number of buckets in all brakings together.

    Returns:
        Edges [s], strictly increasing, at most coarse + fine + one a braking.
    """
    spans = [(max(begin - _AROUND, start), min(stop + _AROUND, end)) for begin, stop in brakings]
    total = sum(stop - begin for begin, stop in spans)
    edges = [np.linspace(start, end, coarse + 1)]
    for begin, stop in spans:
        if stop > begin:
            edges.append(np.linspace(begin, stop, int(fine * (stop - begin) / total) + 1))
    return np.unique(np.concatenate(edges))


def last_of_buckets(time: Array, edges: Array) -> Rows:
    """Return the last row of each bucket, shape (k,): for values that belong together."""
    return np.append(_firsts(time, edges)[1:] - 1, time.size - 1) if time.size else np.empty(0, dtype=np.intp)


def decimate(time: Array, columns: Array, edges: Array) -> tuple[Array, Array]:
    """Keep the least and the greatest value of every column in each bucket, in the order in which they came.

    A bucket of at most two rows stays as it is. One of more becomes two rows, at the times of its first and its last:
    no extreme moves further than its bucket is wide. NaN is kept where a bucket holds nothing else.

    Args:
        time: time of the rows [s], shape (n,), increasing.
        columns: values, shape (n, m); NaN where there is none.
        edges: edges of the buckets [s], shape (b,), increasing.

    Returns:
        Time, shape (k,), and columns, shape (k, m), with k at most n and at most 2 (b + 1).
    """
    if time.size == 0:
        return time, columns
    firsts = _firsts(time, edges)
    counts = np.diff(firsts, append=time.size)
    lasts = firsts + counts - 1
    low, high = np.fmin.reduceat(columns, firsts), np.fmax.reduceat(columns, firsts)
    of_bucket = np.repeat(np.arange(firsts.size), counts)
    rows = np.arange(time.size)[:, None]
    low_at, high_at = (
        np.minimum.reduceat(np.where(columns == extreme[of_bucket], rows, time.size), firsts) for extreme in (low, high)
    )
    falling = high_at < low_at
    full = counts > 2
    begun = np.where(full[:, None], np.where(falling, high, low), columns[firsts])
    ended = np.where(full[:, None], np.where(falling, low, high), columns[lasts])
    pairs = counts > 1
    order = np.argsort(np.concatenate([2 * np.arange(firsts.size), 2 * np.flatnonzero(pairs) + 1]))
    times = np.concatenate([time[firsts], time[lasts[pairs]]])[order]
    return times, np.concatenate([begun, ended[pairs]])[order]


def _firsts(time: Array, edges: Array) -> Rows:
    """Return the first row of each bucket that holds any."""
    return np.flatnonzero(np.diff(np.searchsorted(edges, time, side="right"), prepend=-1))
