"""Ratio of one acceleration to another where slopes drift beneath both.

Block means of half a second are differenced: a hill changes slowly, a pedal does not. The deviation is that of the
ratio without each of ten stretches of the drive (jackknife), which counts noise that lasts.
"""

import numpy as np

from vehicle_doctor.drive import Array
from vehicle_doctor.motion import Motion, NDArrayBool

BLOCK = 0.5
"""Length of a block [s]."""
_PARTS = 10
_LEAST = 8
"""Blocks without which there is no answer."""


def block_means(motion: Motion, signal: Array, use: NDArrayBool) -> Array:
    """Means of blocks of half a second, NaN where a sample of the block is not to be used."""
    width = max(round(BLOCK / motion.step), 2)
    count = signal.size // width
    kept = np.where(use, signal, np.nan)[: count * width]
    return np.asarray(kept.reshape(count, width).mean(axis=1))


def ratio(motion: Motion, signal: Array, reference: Array, use: NDArrayBool) -> tuple[float, float]:
    """Return d signal / d reference and its deviation; NaN where the drive does not excite it."""
    y = np.diff(block_means(motion, signal, use))
    x = np.diff(block_means(motion, reference, use))
    return jackknife(x, y)


def correlation(motion: Motion, signal: Array, reference: Array, use: NDArrayBool) -> float:
    """Return the correlation of the same differences; NaN where there are too few."""
    y = np.diff(block_means(motion, signal, use))
    x = np.diff(block_means(motion, reference, use))
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < _LEAST or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0:
        return np.nan
    return float(np.corrcoef(x[known], y[known])[0, 1])


def jackknife(x: Array, y: Array) -> tuple[float, float]:
    """Return the slope of y = k x through the origin and its deviation."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if x.size < _LEAST or not (x**2).sum() > 0.0:
        return np.nan, np.nan
    parts = np.arange(x.size) * _PARTS // x.size
    sums = np.array([((x * y)[parts == k].sum(), (x * x)[parts == k].sum()) for k in range(_PARTS)])
    total = sums.sum(axis=0)
    rest = total - sums
    if (rest[:, 1] <= 0.0).any():
        return np.nan, np.nan
    without = rest[:, 0] / rest[:, 1]
    return float(total[0] / total[1]), float(np.sqrt((_PARTS - 1) * np.var(without)))
