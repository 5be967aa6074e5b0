"""Filters of finite impulse response, in numpy alone: importing scipy.signal takes longer than all else at start."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def filtered(taps: Array, values: Array) -> Array:
    """Convolution where the filter is full: sum over k of taps[k] values[..., n - k].

    Each result is summed from the oldest value to the newest, as a recursion does sample by sample, so that it does not
    depend on where blocks of values begin.

    Args:
        taps: shape (m,).
        values: shape (..., n), n >= m.

    Returns:
        Shape (..., n - m + 1); the first result belongs to value m - 1.
    """
    last = values.shape[-1] - len(taps) + 1
    oldest, *others = taps[::-1].tolist()
    total = oldest * values[..., :last]
    term = np.empty_like(total)
    for begin, tap in enumerate(others, start=1):
        np.multiply(values[..., begin : begin + last], tap, out=term)
        total += term
    return total
