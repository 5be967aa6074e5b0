"""Least squares on the four fixed exponentials (8.12), section 8.3.1.2, batch and recursive.

The Gram matrix of the first 20 samples has a condition of 1e10 to 1e17, where the covariance form of RLS loses
symmetry and diverges. Here its triangular root is carried with the right-hand side, one orthogonal step a
sample. Started by the regularised batch LS of the first samples, RLS solves the same problem as LS at every
sample and so equals it.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtri

from friction_curve_id.chapter.exponential_curve import ExponentialCurve, regressor, regressor_row
from friction_curve_id.chapter.sample_window import SampleWindow
from friction_curve_id.chapter.square_root import add_row
from friction_curve_id.curve.fitted_curve import FittedCurve

Array = NDArray[np.float64]

RIDGE = 1e-6
"""Added to the diagonal of the Gram matrix. With noise of 0.02 on mu this is a prior of sigma 20 on each
coefficient: it decides only directions that the data do not determine, and after 20 samples there are always some
(condition 1e10 to 1e17)."""


def triangle(slips: Array, frictions: Array) -> Array:
    """Square root of the normal equations: R of [phi mu], with the ridge, shape (7, 7), upper triangular.

    Its last column holds z with R[:6, :6] a = z, and its corner the root of the sum of squares that remains.

    Args:
        slips: shape (n,).
        frictions: mu at them, shape (n,).
    """
    rows = np.column_stack([regressor(slips), frictions])
    ridge = np.column_stack([np.sqrt(RIDGE) * np.eye(6), np.zeros(6)])
    return np.asarray(np.linalg.qr(np.vstack([rows, ridge]), mode="r"))


def solve(root: Array, samples: int, largest_slip: float) -> FittedCurve:
    """Return the curve from a triangle of `samples` samples up to `largest_slip`.

    The covariance is sigma^2 (phi^T phi)^-1, NaN where there are no more samples than parameters. Differenced
    signals share noise between neighbours, which makes it too large rather than too small; it does not include
    the bias of (8.12).
    """
    inverse = dtrtri(root[:6, :6])[0]  # numpy.linalg.inv takes ten times as long
    rest = float(root[6, 6])
    variance = rest * rest / (samples - 6) if samples > 6 else np.nan
    # `dot` is `@` without its search for a loop, which for six parameters takes longer than the product.
    parameters = inverse.dot(root[:6, 6])
    return FittedCurve(ExponentialCurve(largest_slip), parameters, variance * inverse.dot(inverse.T))


class LeastSquares(SampleWindow):
    """Batch LS over the newest samples: a fit from scratch at every sample."""

    def curve(self) -> FittedCurve:
        """Fit the curve."""
        slips, frictions = self.samples()
        return solve(triangle(slips, frictions), len(slips), float(np.max(slips)))


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
