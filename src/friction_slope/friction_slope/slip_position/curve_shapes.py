"""Hypotheses about the friction curve of a tyre: slip of the peak times shape.

    mu(sigma) = mu_max f(sigma / lambda_max),    f(x) = (1 - exp(-p x) - p exp(-p) x) / (1 - exp(-p) - p exp(-p))

This is Burckhardt's curve with its peak at (1, 1). Beyond the peak the shape is stretched, f(1 + c (x - 1)): tyres of
other families rise as one Burckhardt tyre and fall as another.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LAMBDA_MAX: Final = np.geomspace(0.025, 0.5, 30)
"""Slips of the peak [-]: ice and studded rubber below 0.03, cobblestone near 0.4."""
SHAPES: Final = ((1.6, 0.45), (2.5, 0.55), (2.6, 1.0), (4.2, 1.0), (4.4, 0.5), (6.2, 1.0))
"""p and c: brush model, steep Pacejka; Burckhardt on cobblestone and on asphalt; flat Pacejka; Burckhardt on snow."""
SLIDING: Final = 0.35
"""Least friction of a sliding tyre over that of the peak [-]."""
LAMBDA: Final = np.repeat(LAMBDA_MAX, len(SHAPES))
"""Slip of the peak of each hypothesis [-], shape (H,)."""
INITIAL_SLOPE: Final = np.tile(
    [p * (1.0 - np.exp(-p)) / (1.0 - np.exp(-p) - p * np.exp(-p)) for p, _ in SHAPES], LAMBDA_MAX.size
)
"""Slope of f at x = 0 of each hypothesis [-], shape (H,)."""
STEP: Final = float(np.log(LAMBDA_MAX[1] / LAMBDA_MAX[0]))
"""Distance of the slips of the peak, in their logarithm."""

_RESOLUTION: Final = 1000
"""Entries of the table for one unit of x."""
_LARGEST: Final = 16
"""Largest x of the table."""
_COLUMNS: Final = np.tile(np.arange(len(SHAPES)), LAMBDA_MAX.size)


def _tables() -> tuple[Array, Array]:
    x = (np.arange(_LARGEST * _RESOLUTION) + 0.5) / _RESOLUTION
    columns = []
    for p, c in SHAPES:
        bent = np.where(x > 1.0, 1.0 + c * (x - 1.0), x)
        end = np.exp(-p)
        f = (1.0 - np.exp(-p * bent) - p * end * bent) / (1.0 - end - p * end)
        columns.append(np.where(x > 1.0, np.maximum(f, SLIDING), f))
    values = np.array(columns).T
    return values.ravel(), np.gradient(values, 1.0 / _RESOLUTION, axis=0).ravel()


_VALUES, _SLOPES = _tables()


def friction_ratio(sigma: Array) -> Array:
    """f at slips sigma [-] >= 0 of n wheels, shape (n, H), for each hypothesis [-]."""
    return np.take(_VALUES, _places(sigma))


def friction_ratio_and_slope(sigma: Array) -> tuple[Array, Array]:
    """f and its derivative by the slip [-], shapes as in `friction_ratio`."""
    places = _places(sigma)
    return np.take(_VALUES, places), np.take(_SLOPES, places) / LAMBDA


def _places(sigma: Array) -> NDArray[np.int64]:
    places = np.minimum(sigma * (_RESOLUTION / LAMBDA), _LARGEST * _RESOLUTION - 1).astype(np.int64)
    places *= len(SHAPES)
    places += _COLUMNS
    return places
