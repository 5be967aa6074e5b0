"""Flat rows of a result: columns, values as text and as JSON, limits.

A row with a limit has `value`, `limit` and `passed`. Where `passed` is None or absent, the row is for information.
"""

from collections.abc import Sequence
from math import isfinite, isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

Row = dict[str, Any]
"""Names and numbers or texts."""


def columns(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, in the order in which they first appear; every row may have its own."""
    return list(dict.fromkeys(name for row in rows for name in row))


def as_text(value: Any) -> str:
    """Four significant digits of a float, a dash for NaN, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, float):
        return "–" if isnan(value) else f"{value:.4g}"
    return str(value)


def at_most(value: float, limit: float) -> Row:
    """Columns of a row whose value may not be above the limit; NaN does not pass."""
    return {"value": value, "limit": limit, "passed": bool(value <= limit)}


def at_least(value: float, limit: float) -> Row:
    """Columns of a row whose value may not be below the limit; NaN does not pass."""
    return {"value": value, "limit": limit, "passed": bool(value >= limit)}


def not_judged(value: float) -> Row:
    """Columns of a row for information among rows that have a limit."""
    return {"value": value, "limit": None, "passed": None}


def failures(rows: Sequence[Row]) -> list[Row]:
    """Return the rows that do not hold."""
    return [row for row in rows if row.get("passed") not in (None, True)]


def plain(row: Row) -> Row:
    """JSON has no NaN and no infinity: they become null and the text "inf"."""
    found: Row = {}
    for name, value in row.items():
        if hasattr(value, "item"):
            value = value.item()
        if isinstance(value, float) and not isfinite(value):
            value = None if isnan(value) else ("inf" if value > 0 else "-inf")
        found[name] = value
    return found


def run_lengths(true: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lengths of all runs of true values down each column of an array of shape (n, wheels)."""
    padded = np.pad(true, ((1, 1), (0, 0))).astype(np.int8).T
    edges = np.diff(padded, axis=1).ravel()
    return np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
