"""Recursive maximum likelihood (RML) and RML with batch iterations (RML+ML), section 8.3.1.1.

The recursion is (8.10) turned into recursive least squares: one Gauss-Newton step a sample with the gain
P xi, P^-1 = sum of xi xi^T. As printed it is unsound twice, and this form differs so that it cannot diverge:
- P^-1 of the first samples is singular to working precision (condition 1e10 and more). Here its square root R is
  carried (P^-1 = R^T R, updated by a QR step) and it begins with a prior around theta(0);
- at low slip the data determine th1 th2 and nothing else, a hyperbola in theta on which a linear step goes astray.
  The recursion runs in (ln th1, ln th2, th3), where it is a straight line; the steps end at the box of sensible
  curves.

The extra gain of the chapter multiplies the steps of th2 and th3. Alone that would leave the line of curves that
fit the past and oscillate, so th1 follows: it is fitted again, given the longer steps, to the information in R. A gain
below 2 keeps the recursion stable (an error of the linearised prediction shrinks by at most |1 - gain|).
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.chapter.maximum_likelihood import initial_theta
from friction_curve_id.chapter.square_root import add_row
from friction_curve_id.curve.burckhardt_curve import (
    UNKNOWNS_HIGH,
    UNKNOWNS_LOW,
    BurckhardtCurve,
    theta_per_unknown,
    to_theta,
    to_unknowns,
)
from friction_curve_id.curve.fitted_curve import FittedCurve
from vehicle_models import burckhardt

Array = NDArray[np.float64]

_PRIOR_STDDEV = np.array([0.5, 0.7, 0.2])
"""Standard deviations of ln th1, ln th2 and th3 around theta(0)."""
_FRICTION_NOISE = 0.02
"""Noise of mu that weighs the prior against the samples [-]."""
_LONGEST_STEP = 1.0
"""Longest step at one sample, in standard deviations of the prior: beyond it the linearisation does not hold."""
_NOISE_SAMPLES = 10
"""Weight of the assumed noise in the estimate of the noise, in samples."""


def _scale(theta: Array) -> Array:
    """d theta / d (unknowns in standard deviations of the prior), diagonal, shape (3,)."""
    return theta_per_unknown(theta) * _PRIOR_STDDEV


def _triangular(rows: Array) -> Array:
    return np.asarray(np.linalg.qr(rows, mode="r"))


class RecursiveML:
    """RML in square-root form."""

    def __init__(self, extra_gain: float = 1.2) -> None:
        """Choose the extra gain on the steps of th2 and th3, in [1, 2).

        Raises:
            ValueError: the gain is outside [1, 2).
        """
        if not 1.0 <= extra_gain < 2.0:
            raise ValueError(f"extra_gain must be in [1, 2), is {extra_gain}")
        self._extra_gain = extra_gain
        self._prior = self._unknowns = np.zeros(3)
        self._root = np.eye(3)
        self._squares, self._count = 0.0, 0

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with theta(0) by (8.11) and the information of the first samples, shapes (n,)."""
        theta = initial_theta(slips, frictions)
        self._prior = to_unknowns(theta)
        self._unknowns = self._prior.copy()
        self._linearise(slips)
        residuals = frictions - burckhardt.friction(theta, slips)
        self._squares = float(residuals @ residuals) + _NOISE_SAMPLES * _FRICTION_NOISE**2
        self._count = len(slips) + _NOISE_SAMPLES

    def add(self, slip: float, friction: float) -> float:
        """Take one more sample and return its prediction error [-]."""
        theta = to_theta(self._unknowns)
        row = burckhardt.gradient(theta, slip) * _scale(theta)
        error = friction - float(burckhardt.friction(theta, slip))
        self._root = add_row(self._root, row)
        step = self._solve(row * error)
        longer = (self._extra_gain - 1.0) * step[1:]
        step[1:] += longer
        step[0] -= self._root[0, 1:] @ longer / self._root[0, 0]
        step /= max(1.0, float(np.max(np.abs(step))) / _LONGEST_STEP)
        self._unknowns = np.clip(self._unknowns + step * _PRIOR_STDDEV, UNKNOWNS_LOW, UNKNOWNS_HIGH)
        after = friction - float(burckhardt.friction(to_theta(self._unknowns), slip))
        self._squares += abs(error * after)
        self._count += 1
        return error

    def iterate(self, slips: Array, frictions: Array, iterations: int) -> None:
        """Improve by a few batch steps (8.10) over all samples, shapes (n,), and continue from there."""
        for _ in range(iterations):
            theta = to_theta(self._unknowns)
            residuals = frictions - burckhardt.friction(theta, slips)
            self._linearise(slips)
            rows = burckhardt.gradient(theta, slips) * _scale(theta)
            pull = _FRICTION_NOISE**2 * (self._prior - self._unknowns) / _PRIOR_STDDEV
            step = self._solve(rows.T @ residuals + pull)
            self._unknowns = np.clip(
                self._unknowns + np.clip(step, -1.0, 1.0) * _PRIOR_STDDEV, UNKNOWNS_LOW, UNKNOWNS_HIGH
            )
        self._linearise(slips)

    def curve(self) -> FittedCurve:
        """The curve so far; its covariance is that of the linearised recursion."""
        theta = to_theta(self._unknowns)
        inverse_root = np.linalg.inv(self._root) * np.sqrt(self._squares / self._count)
        columns = _scale(theta)[:, np.newaxis] * inverse_root
        return FittedCurve(BurckhardtCurve(), theta, columns @ columns.T)

    def _solve(self, right: Array) -> Array:
        """P times `right`, through the square root."""
        return np.asarray(np.linalg.solve(self._root, np.linalg.solve(self._root.T, right)))

    def _linearise(self, slips: Array) -> None:
        theta = to_theta(self._unknowns)
        rows = burckhardt.gradient(theta, slips) * _scale(theta)
        self._root = _triangular(np.vstack([rows, _FRICTION_NOISE * np.eye(3)]))


class RecursiveMLWithBatch:
    """RML+ML: a few batch iterations as soon as the recursion no longer improves.

    It no longer improves when the mean square prediction error over the last ten samples is not a tenth below that of
    the ten before.
    """

    _PERIOD = 10
    _ITERATIONS = 3
    _IMPROVEMENT = 0.9

    def __init__(self, extra_gain: float = 1.2, window: int = 400) -> None:
        """Choose the extra gain of the recursion and how many samples, the newest, a batch iteration takes."""
        self._recursion = RecursiveML(extra_gain)
        self._points: deque[tuple[float, float]] = deque(maxlen=window)

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin as RML does with the first samples, shapes (n,)."""
        self._points.clear()
        self._points.extend(zip(slips.tolist(), frictions.tolist(), strict=True))
        self._recursion.start(slips, frictions)
        self._errors: list[float] = []
        self._last_mean_square = np.inf
        self.batches = 0
        """Number of batches of iterations since the start."""

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        self._points.append((slip, friction))
        self._errors.append(self._recursion.add(slip, friction))
        if len(self._errors) < self._PERIOD:
            return
        mean_square = float(np.mean(np.square(self._errors)))
        self._errors.clear()
        if mean_square >= self._IMPROVEMENT * self._last_mean_square:
            slips, frictions = np.array(self._points).T
            self._recursion.iterate(slips, frictions, self._ITERATIONS)
            self.batches += 1
        self._last_mean_square = mean_square

    def curve(self) -> FittedCurve:
        """The curve so far."""
        return self._recursion.curve()
