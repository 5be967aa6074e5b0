"""Causal derivative estimators: a polynomial fitted to the last samples by least squares.

Over the window the signal is taken as a polynomial of degree d in time; order k of its derivative is read `delay`
before the newest sample. On a uniform grid these are the Savitzky-Golay filters; the weights follow the stamps, so that
jitter and lost samples leave the result exact for every polynomial of degree d.

Delay: read at the centre of the window, (N - 1) T / 2 before the newest sample at sample time T, the estimate is a
weighted mean of the true derivative around that point, with the least variance. Read nearer to the newest sample it is
younger and noisier; past it (a negative delay) it is a prediction. A fit of degree d = k is the same everywhere in the
window, and its delay is that of the centre.
"""

from math import factorial, nan, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models.nanoseconds import NANOSECOND

Array = NDArray[np.float64]


def polynomial_weights(offsets: ArrayLike, degree: int, order: int, delay: float) -> Array:
    """Weights that turn samples at `offsets` into a derivative of the fitted polynomial.

    Args:
        offsets: times of the samples against the newest [s], ascending to 0, shape (n,), all different.
        degree: degree of the polynomial, < n.
        order: order of the derivative, 0..degree.
        delay: time before the newest sample at which the derivative is read [s].

    Returns:
        Shape (n,), in 1/s^order: the derivative is their product with the samples.

    Raises:
        ValueError: degree or order do not fit, or the offsets do not ascend.
    """
    times = np.asarray(offsets, dtype=np.float64)
    if not 0 <= order <= degree < times.size:
        raise ValueError(f"need 0 <= order ({order}) <= degree ({degree}) < samples ({times.size})")
    if not (times[1:] > times[:-1]).all():
        raise ValueError("offsets must ascend")
    centre, scale = 0.5 * (times[0] + times[-1]), 0.5 * (times[-1] - times[0])
    # Scaled to [-1, 1] and read through powers about the centre, the normal equations stay well conditioned.
    powers = np.vander((times - centre) / scale, degree + 1, increasing=True)
    point = (times[-1] - delay - centre) / scale
    reading = np.zeros(degree + 1)
    for k in range(order, degree + 1):
        reading[k] = factorial(k) / factorial(k - order) * point ** (k - order)
    return np.asarray(powers @ np.linalg.solve(powers.T @ powers, reading)) / scale**order


class LocalPolynomial:
    """Sliding window of samples of one or several signals, and derivatives of the polynomial through it.

    Uses plain floats: for a few dozen of them a numpy product takes several times as long.
    """

    def __init__(self, window: int, degree: int, signals: int = 1) -> None:
        """Start empty.

        Args:
            window: number of samples N, > degree.
            degree: degree of the polynomial, >= 0.
            signals: number of signals that are sampled together; they share the stamps.

        Raises:
            ValueError: the window is too short for the degree.
        """
        if not 0 <= degree < window:
            raise ValueError(f"window ({window} samples) must be longer than degree ({degree}) >= 0")
        self._window, self._degree, self._signals = window, degree, signals
        self.reset()

    def reset(self) -> None:
        """Forget every sample."""
        self._stamps = [0] * self._window
        # Written twice, half a ring apart, the window is always one contiguous block, oldest sample first.
        self._values: list[list[float]] = [[0.0] * (2 * self._window) for _ in range(self._signals)]
        self._next = 0
        self._count = 0
        self._interval = 0
        self._equal_intervals = 0
        self._weights: dict[tuple[int, float], list[float]] = {}
        self._earlier_weights: dict[int, list[float]] = {}
        self.ready = False
        """Whether the window is full."""
        self.span = 0.0
        """Time from the oldest to the newest sample of the window [s]; 0 while it is not full."""

    def update(self, stamp: int, values: list[float]) -> None:
        """Take a sample of every signal.

        Args:
            stamp: stamp [ns], later than the last.
            values: sample of each signal, NaN where it is unknown.
        """
        at = self._next
        interval = stamp - self._stamps[at - 1] if self._count > 0 else 0
        self._stamps[at] = stamp
        for signal, value in enumerate(values):
            ring = self._values[signal]
            ring[at] = ring[at + self._window] = value
        self._next = at + 1 if at + 1 < self._window else 0
        self._equal_intervals = self._equal_intervals + 1 if interval == self._interval else 1
        self._interval = interval
        # Span and weights follow from the offsets. These repeat if the new interval equals the one that left and all
        # those between.
        if self._equal_intervals < self._window or not self.ready:
            self._count += 1
            self._weights.clear()
            self._earlier_weights.clear()
            self.ready = self._count >= self._window
            self.span = (stamp - self._stamps[self._next]) * NANOSECOND if self.ready else 0.0

    def derivative(self, order: int, delay: float, signal: int = 0) -> float:
        """Derivative of a signal `delay` [s] before the newest sample; NaN if any of its samples is.

        Raises:
            ValueError: the window is not full, or order is not in 0..degree.
        """
        if not self.ready:
            raise ValueError(f"window is not full: {self._count} of {self._window} samples")
        weights = self._weights.get((order, delay))
        if weights is None:
            stamps = self._in_order()
            offsets = (stamps - stamps[-1]) * NANOSECOND
            weights = self._weights[order, delay] = polynomial_weights(offsets, self._degree, order, delay).tolist()
        return self._weighted(weights, signal)

    def earlier(self, order: int, signal: int = 0) -> float:
        """Derivative of a signal at the centre of the older half of the window, by the samples of that half alone.

        The half has one sample more than the degree at least, so that of a short window it is more than half.

        Raises:
            ValueError: the window is not full, or order is not in 0..degree.
        """
        if not self.ready:
            raise ValueError(f"window is not full: {self._count} of {self._window} samples")
        weights = self._earlier_weights.get(order)
        if weights is None:
            stamps = self._in_order()
            stamps = stamps[: max(self._window // 2, self._degree + 1)]
            offsets = (stamps - stamps[-1]) * NANOSECOND
            weights = polynomial_weights(offsets, self._degree, order, -0.5 * float(offsets[0])).tolist()
            self._earlier_weights[order] = weights
        return self._weighted(weights, signal)

    def _in_order(self) -> NDArray[np.int64]:
        """Stamps of the window [ns], the oldest first, shape (window,)."""
        return np.array(self._stamps[self._next :] + self._stamps[: self._next])

    def _weighted(self, weights: list[float], signal: int) -> float:
        values = self._values[signal]
        place = self._next
        total = 0.0
        for weight in weights:
            total += weight * values[place]
            place += 1
        return total

    def scatter(self, signal: int = 0) -> float:
        """Standard deviation of the samples of a signal about the polynomial; NaN if one is not finite.

        A window so short that the polynomial goes through all of its samples shows none: 0.

        Raises:
            ValueError: the window is not full.
        """
        if not self.ready:
            raise ValueError(f"window is not full: {self._count} of {self._window} samples")
        freedom = self._window - self._degree - 1
        if freedom == 0:
            return 0.0
        stamps = self._in_order()
        powers = np.vander((stamps - stamps[0]) / (stamps[-1] - stamps[0]), self._degree + 1)
        values = np.array(self._values[signal][self._next : self._next + self._window])
        if not np.isfinite(values).all():
            return nan
        rest = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
        return sqrt(float(rest @ rest) / freedom)
