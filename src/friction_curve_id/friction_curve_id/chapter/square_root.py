"""The triangular square root R of normal equations, R^T R = X^T X, carried from sample to sample."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgeqrf

Array = NDArray[np.float64]


def add_row(root: Array, row: Array) -> Array:
    """R with one more row in X, by an orthogonal step: the square of its condition never appears.

    numpy.linalg.qr gives the same, from the same LAPACK, after checks that take several times as long as the step.

    Args:
        root: R so far, upper triangular, shape (n, n).
        row: shape (n,).

    Returns:
        Upper triangular, shape (n, n).
    """
    n = len(row)
    rows = np.empty((n + 1, n), order="F")
    rows[:n] = root
    rows[n] = row
    factored = dgeqrf(rows, overwrite_a=True)[0]
    return np.where(_upper(n), factored[:n], 0.0)


@cache
def _upper(n: int) -> NDArray[np.bool_]:
    return np.tri(n, dtype=bool).T
