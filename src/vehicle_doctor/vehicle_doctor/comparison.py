"""Comparison of two signals of a drive where a slowly varying offset, such as the road grade, adds to one of them.

`ratio` and `correlation` difference means of half a second: a hill changes slowly, a pedal does not. `shift` estimates
gain k and delay T by iterated least squares on overlapping stretches, with a polynomial c of each stretch,

    y(t) = c_0 + c_1 t + k x(t - T)

linear in T about the present one; the first comes from a scan. All standard deviations are jackknife estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_doctor.drive import Array
from vehicle_doctor.motion import Motion, NDArrayBool, moving_mean

BLOCK = 0.5
"""Length of a block [s]."""
_PARTS = 10
_MIN_BLOCKS = 8
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
    if known.sum() < _MIN_BLOCKS or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0:
        return np.nan
    return float(np.corrcoef(x[known], y[known])[0, 1])


def jackknife(x: Array, y: Array) -> tuple[float, float]:
    """Return the slope of y = k x through the origin and its deviation."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if x.size < _MIN_BLOCKS or not (x**2).sum() > 0.0:
        return np.nan, np.nan
    parts = np.arange(x.size) * _PARTS // x.size
    sums = np.array([((x * y)[parts == k].sum(), (x * x)[parts == k].sum()) for k in range(_PARTS)])
    total = sums.sum(axis=0)
    rest = total - sums
    if (rest[:, 1] <= 0.0).any():
        return np.nan, np.nan
    without = rest[:, 0] / rest[:, 1]
    return float(total[0] / total[1]), float(np.sqrt((_PARTS - 1) * np.var(without)))


_REACH = 0.5
"""Largest shift that is looked for [s]."""
_COARSE = 0.02
"""Steps of the shifts that are tried first [s]."""
_MEMORY = 0.3
"""Time after which what one signal does not explain of the other is independent [s]."""
_ROUNDS = 8
_PARTS = 10


@dataclass(frozen=True)
class Shift:
    """A signal later than another by a time, and its gain."""

    late: float
    """[s]"""
    late_stddev: float
    """[s]"""
    gain: float
    gain_stddev: float


def stretches(motion: Motion, use: NDArrayBool, shortest: float, longest: float) -> list[slice]:
    """Return stretches in which all samples are to be used, of at least and at most some times [s]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], use.astype(np.int8), [0]])))
    least, most = round(shortest / motion.step), round(longest / motion.step)
    found = []
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        parts = max(-(-(end - begin) // most), 1)
        for k in range(parts):
            part = slice(begin + k * (end - begin) // parts, begin + (k + 1) * (end - begin) // parts)
            if part.stop - part.start >= least:
                found.append(part)
    return found


def shift(
    motion: Motion, x: Array, y: Array, where: Sequence[slice], order: int = 1, rate_noise: float = 0.0
) -> Shift | None:
    """Return by how much y is later than x, and dy / dx; None where the segments do not determine it.

    Args:
        motion: time axis.
        x: the earlier signal, (N,).
        y: the later one, (N,); both smoothed alike inside.
        where: stretches, at least three.
        order: of the polynomial in time that is taken out of each.
        rate_noise: deviation of the white noise in the rate of x, of which x is the integral. What it makes of x is no
            part of y: its share of the variation of x is a share of the gain and of the range of the shift in doubt.
    """
    width = 2 * max(round(0.02 / motion.step), 1) + 1
    x, y = moving_mean(x, width), moving_mean(y, width)
    usable = [part for part in where if np.isfinite(y[part]).all()]
    if len(usable) < 3:
        return None
    known = np.isfinite(x)
    if not known.any():
        return None
    time = motion.time
    filled = np.interp(time, time[known], x[known])

    def moved(late: float) -> Array:
        return np.asarray(np.interp(time - late, time, filled))

    def sums(late: float) -> Array:
        """Normal equations of each stretch: of x, dx/dt and y without the polynomial, (m, 3, 3)."""
        now, change = moved(late), (moved(late - motion.step) - moved(late + motion.step)) / (2.0 * motion.step)
        found = []
        for part in usable:
            columns = np.column_stack([now[part], change[part], y[part]])
            basis = np.vander(np.linspace(-1.0, 1.0, columns.shape[0]), order + 1)
            columns = columns - basis @ np.linalg.lstsq(basis, columns, rcond=None)[0]
            found.append(columns.T @ columns)
        return np.array(found)

    def unexplained(late: float) -> float:
        n = sums(late).sum(axis=0)
        return float(n[2, 2] - n[0, 2] ** 2 / n[0, 0]) if n[0, 0] > 0.0 else np.inf

    coarse = np.arange(-_REACH, _REACH + 1e-9, _COARSE)
    left = np.array([unexplained(each) for each in coarse])
    late = float(coarse[left.argmin()])
    late = min(np.arange(late - _COARSE, late + _COARSE + 1e-3, 0.005), key=unexplained)
    for _ in range(_ROUNDS):
        gain, step = _solved(sums(late).sum(axis=0))
        if not np.isfinite(step) or abs(late - step) > 1.2 * _REACH:
            return None
        late -= float(np.clip(step, -0.02, 0.02))
        if abs(step) < 1e-5:
            break
    each = sums(late)
    total = each.sum(axis=0)
    doubt = min(_wandering(motion, usable, order, rate_noise) / float(total[0, 0]), 1.0)
    group = np.arange(len(usable)) % min(_PARTS, len(usable))
    without = np.array([_solved(total - each[group == k].sum(axis=0)) for k in range(int(group.max()) + 1)])
    deviation = np.sqrt((without.shape[0] - 1) * np.var(without, axis=0))
    gain, _ = _solved(total)
    others = _spread(coarse, left, late, sum(part.stop - part.start for part in usable) * motion.step)
    late_stddev, gain_stddev = np.hypot(deviation[::-1], [np.hypot(doubt * _REACH, others), doubt * abs(gain)])
    return Shift(float(late), float(late_stddev), float(gain), float(gain_stddev))


def _spread(shifts: Array, left: Array, late: float, duration: float) -> float:
    """Return how far the shifts that explain the signals hardly worse lie from the best one [s].

    Args:
        shifts: [s], (k,).
        left: sum of squares that each leaves unexplained, (k,).
        late: the best [s].
        duration: of the stretches together [s].
    """
    least = float(left.min())
    if not least > 0.0 or not np.isfinite(left).all():
        return 0.0
    likelihood = (left / least) ** (-0.5 * duration / _MEMORY)
    return float(np.sqrt(max(likelihood @ (shifts - late) ** 2 / likelihood.sum() - _COARSE**2, 0.0)))


def _wandering(motion: Motion, where: Sequence[slice], order: int, rate_noise: float) -> float:
    """Return the sum of squares of the integral of white noise in stretches, the polynomial of each taken out.

    Of a random walk over n steps, a polynomial of order m leaves about n / (7.5 (m + 1)) times the variance of a step.
    """
    steps = np.array([part.stop - part.start for part in where], dtype=np.float64)
    return float(np.sum(steps**2) / (7.5 * (order + 1)) * (rate_noise * motion.step) ** 2)


def _solved(n: Array) -> tuple[float, float]:
    """Gain and shift left to make, from normal equations."""
    if not np.linalg.det(n[:2, :2]) > 0.0:
        return np.nan, np.nan
    gain, slope = np.linalg.solve(n[:2, :2], n[:2, 2])
    return float(gain), float(slope / gain) if gain else np.nan
