"""The triangular square root R of normal equations, R^T R = X^T X, carried from sample to sample."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtpqrt

Array = NDArray[np.float64]


def add_row(root: Array, row: Array) -> Array:
    """R with one more row in X, by an orthogonal step: the square of its condition never appears.

    Args:
        root: R so far, upper triangular, shape (n, n).
        row: shape (n,).

    Returns:
        Upper triangular, shape (n, n).
    """
    added: Array = dtpqrt(0, len(row), root, row[np.newaxis])[0]
    return added
