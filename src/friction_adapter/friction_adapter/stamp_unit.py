"""Units of stamps: by a key of the map, by the name of a column, by their size or by the time between them.

A time since 1970 has a size that tells its unit: today it is 1.7e9 s, 1.7e12 ms, 1.7e15 us or 1.7e18 ns. A time since
the beginning of a log does not, so that there its steps are compared with those of a drive.
"""

import re
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite, log, nan
from statistics import median
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

STAMP_UNITS: Final = {"s": NANOSECONDS, "ms": 10**6, "us": 10**3, "ns": 1, "days": 86_400 * NANOSECONDS}
"""Nanoseconds in each unit."""
_EPOCHS: Final = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"))
"""Least time since 1970 in each unit: that of March 1973."""
_DAYS_TO_1970: Final = ((719_529.0, "MATLAB"), (25_569.0, "Excel"))
"""1 January 1970 in the days of other tools, the largest first."""
_USUAL: Final = 0.01
"""Time between two rows of a drive [s]."""
_FASTEST, _SLOW, _SLOWEST = 5e-5, 0.5, 2.0
"""Least time between two rows of a drive, the largest one that is taken for one unasked, and the largest [s]."""
_LEAST_STEPS: Final = 10
"""Steps without which nothing is known of the unit."""
_IN_A_NAME: Final = re.compile(r"(?:[\[(]\s*|[_ ])(s|sec|seconds|ms|us|µs|ns|days)\s*[\])]?$", re.IGNORECASE)
_SPELLINGS: Final = {"sec": "s", "seconds": "s", "µs": "us"}
TIME_COLUMNS: Final = ("time", "t", "stamp", "timestamp", "time stamp", "zeit", "datetime")
"""Names of a column of times, without a unit."""


def unit_by_name(column: str) -> str:
    """Return the unit that the name of a column ends with, as `Time [ms]` or `time_us`; empty where there is none."""
    found = _IN_A_NAME.search(column)
    return "" if found is None else _SPELLINGS.get(found[1].lower(), found[1].lower())


def unit_by_size(stamp: float) -> str:
    """Return the unit of a time since 1970; empty for one of few digits, which is seconds or none since 1970."""
    return next((unit for least, unit in _EPOCHS if stamp >= least), "")


def unit_by_steps(stamps: Sequence[float]) -> tuple[str, float]:
    """Return the unit of the stamps of a drive, and the usual time between two [in that unit]; empty and NaN: unknown.

    Steps of about 1 are unknown: they are those of milliseconds, or of a log in seconds that is too slow for a drive.
    """
    steps = [later - sooner for sooner, later in pairwise(stamps) if later > sooner]
    step = median(steps) if len(steps) >= _LEAST_STEPS else nan
    size = unit_by_size(max(stamps, default=0.0))
    if size or not isfinite(step) or _FASTEST <= step <= _SLOW:
        return size or "s", step
    possible = [unit for unit in STAMP_UNITS if is_step(step, unit) and not is_step(step, "s")]
    return min(possible, key=lambda unit: abs(log(step * STAMP_UNITS[unit] / NANOSECONDS / _USUAL)), default=""), step


def is_step(step: float, unit: str) -> bool:
    """Whether a drive can have such a step in a unit; NaN, of a drive of one row, is no reason against it."""
    return not isfinite(step) or _FASTEST <= step * STAMP_UNITS[unit] / NANOSECONDS <= _SLOWEST


def unit_by_pace(stamps: float, time: float) -> str:
    """Return the unit in which stamps run by `stamps` within a time [s]; empty where none is near."""
    return next((unit for unit, each in STAMP_UNITS.items() if 0.5 < stamps * each / NANOSECONDS / time < 2.0), "")


def nanoseconds_of(stamp: float, unit: str) -> int:
    """Return a stamp in nanoseconds.

    Args:
        stamp: the stamp, of any sign; that of days may be a serial date of a spreadsheet or of MATLAB.
        unit: key of STAMP_UNITS; empty for that by the size.

    Raises:
        ValueError, OverflowError: it is no finite number.
    """
    if unit == "days":
        stamp -= next((days for days, _ in _DAYS_TO_1970 if stamp >= days), 0.0)
    # a whole number stays one: a double does not hold a nanosecond since 1970
    return round(stamp * STAMP_UNITS[unit or unit_by_size(stamp) or "s"])
