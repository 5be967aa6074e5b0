"""Flat rows of a result: their columns, and their values as text and as JSON."""

from collections.abc import Sequence
from math import isfinite, isnan
from typing import Any

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
