"""Durations of the intervals in which a condition holds."""

import numpy as np
from numpy.typing import NDArray


def run_lengths(true: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lengths of all runs of true values down each column of an array of shape (n, wheels)."""
    padded = np.pad(true, ((1, 1), (0, 0))).astype(np.int8).T
    edges = np.diff(padded, axis=1).ravel()
    return np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
