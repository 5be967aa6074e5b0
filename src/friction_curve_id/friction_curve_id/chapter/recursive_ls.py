"""Recursive least squares on the four fixed exponentials (8.12), section 8.3.1.2, in square-root (QR) form.

The Gram matrix of the first 20 samples has a condition of 1e10 to 1e17, where the covariance form of RLS loses
symmetry and diverges. Here its triangular root is carried with the right-hand side, one orthogonal step a
sample. Started by the regularised batch LS of the first samples, it solves the same problem as LS at every
sample and so equals it.
"""

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.chapter.exponential_curve import regressor_row
from friction_curve_id.chapter.least_squares import solve, triangle
from friction_curve_id.chapter.square_root import add_row
from friction_curve_id.curve.fitted_curve import FittedCurve

Array = NDArray[np.float64]


class RecursiveLS:
    """Recursive least squares with constant memory."""

    def __init__(self) -> None:
        """Wait for the first samples."""
        self._root: Array = np.zeros((7, 7))
        self._samples = 0
        self._largest_slip = 0.0

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with the batch LS of the first samples, shapes (n,)."""
        self._root = triangle(slips, frictions)
        self._samples = len(slips)
        self._largest_slip = float(np.max(slips))

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        row = np.empty(7)
        row[:6] = regressor_row(slip)
        row[6] = friction
        self._root = add_row(self._root, row)
        self._samples += 1
        self._largest_slip = max(self._largest_slip, slip)

    def curve(self) -> FittedCurve:
        """The curve so far."""
        return solve(self._root, self._samples, self._largest_slip)
