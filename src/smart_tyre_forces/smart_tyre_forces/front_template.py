"""Fronts by a matched template, for rough roads: generalised least squares with noise learned from the free belt.

Around the patch the normalised signal is

    z = A s_1(theta - alpha_1) + B + noise    up to the middle of the patch,
    z = A s_2(theta - alpha_2) + B + noise    after it,

with s_1 and s_2 the mean waveforms of the two fronts. The noise is not white (the road shakes between 150 and 2000
Hz), so residuals are whitened by the autoregressive filter that fits the noise on the free belt. Two Gauss-Newton
steps for (A, B, alpha_1, alpha_2) from the crossings then come close to the Cramer-Rao bound.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.fir import filtered
from smart_tyre_forces.fronts import NOISE_END, Fronts

Array = NDArray[np.float64]

GRID = np.radians(np.arange(-45.0, 45.1, 0.2))
"""Angle after the front at which a template is tabulated [rad]."""
_REACH = np.radians(32.0)
"""How far the fit reaches out of the patch, before and after it [rad]."""
_FARTHEST = np.radians(6.0)
"""Largest distance of a valid front from its crossing [rad]."""
_ORDER = 60
"""Order of the noise filter: 6 ms at 10 kHz, enough to resolve the quiet band below 150 Hz."""
_FORGETTING = 0.1
"""Weight of the newest revolution in the noise."""
_RIDGE = 1e-4
"""Share of the noise power added to the whole band, so that a quiet band is not trusted without limit."""


class FrontRefiner(Protocol):
    """Processes each passage once its fronts have been found by crossing."""

    def refine(self, fronts: Fronts, theta: Array, acceleration: Array) -> Fronts | None:
        """Return better fronts, or None where there are none.

        Args:
            fronts: fronts found by crossing.
            theta: wheel angle of the samples about the expected centre [rad], from half a revolution before it on.
            acceleration: acceleration at those samples [m/s^2].
        """
        ...


@dataclass(frozen=True)
class FrontTemplate:
    """Mean normalised waveforms (0 in the patch, 1 on the free belt) on GRID."""

    leading: Array
    """Waveform about the front where the sensor enters the patch, shape (len(GRID),)."""
    trailing: Array
    """Waveform about the front where the sensor leaves the patch, shape (len(GRID),)."""

    def __post_init__(self) -> None:
        """Refuse tables of the wrong length or with gaps."""
        for table in (self.leading, self.trailing):
            if table.shape != GRID.shape or not np.all(np.isfinite(table)):
                raise ValueError(f"front template: needs {len(GRID)} finite values, has shape {table.shape}")


class TemplateLearner:
    """Mean waveform over the passages seen; leaves the fronts as they are."""

    def __init__(self) -> None:
        """Start empty."""
        self._sums = np.zeros((2, len(GRID)))
        self._count = 0

    def refine(self, fronts: Fronts, theta: Array, acceleration: Array) -> Fronts | None:
        """Add one passage."""
        normalised = (acceleration - fronts.floor) / fronts.step
        for row, front in enumerate((fronts.alpha_1, fronts.alpha_2)):
            self._sums[row] += np.interp(GRID + front, theta, normalised)
        self._count += 1
        return fronts

    @property
    def template(self) -> FrontTemplate:
        """Return the mean so far.

        Raises:
            ValueError: no passage was seen.
        """
        if self._count == 0:
            raise ValueError("front template: no passage seen")
        return FrontTemplate(self._sums[0] / self._count, self._sums[1] / self._count)


class TemplateFit:
    """Fits a template to the fronts of passage after passage of one wheel."""

    def __init__(self, template: FrontTemplate) -> None:
        """Start with no knowledge of the noise: the first passage gives the first estimate."""
        # Here, because nodes without a template start faster without it; the first passage must not wait for it either.
        from scipy.linalg import solve_toeplitz

        self._solve_toeplitz = solve_toeplitz
        self._tables = (template.leading, template.trailing)
        self._slopes = tuple(np.gradient(table, GRID) for table in self._tables)
        self._covariance: Array | None = None

    def refine(self, fronts: Fronts, theta: Array, acceleration: Array) -> Fronts | None:
        """Fit both fronts of a passage."""
        whitener = self._whitener(acceleration[: int(np.searchsorted(theta, NOISE_END))])
        if whitener is None:
            return None
        return self._fit(fronts, theta, (acceleration - fronts.floor) / fronts.step, whitener)

    def _whitener(self, free: Array) -> Array | None:
        """Prediction-error filter of the noise on the free belt, shape (order + 1,)."""
        if len(free) < 2 * _ORDER:
            return None
        ramp = np.linspace(-1.0, 1.0, len(free))
        noise = free - np.mean(free) - ramp * (np.dot(ramp, free) / np.dot(ramp, ramp))
        lags = np.array([np.dot(noise[: len(noise) - lag], noise[lag:]) for lag in range(_ORDER + 1)]) / len(noise)
        # Relative: a faster revolution is louder, not more informative.
        lags = lags / lags[0] if lags[0] > 0.0 else np.eye(1, _ORDER + 1)[0]
        if self._covariance is None:
            self._covariance = lags
        else:
            self._covariance = self._covariance + _FORGETTING * (lags - self._covariance)
        column = self._covariance[:_ORDER].copy()
        column[0] *= 1.0 + _RIDGE
        return np.concatenate(((1.0,), -self._solve_toeplitz(column, self._covariance[1:])))

    def _fit(self, fronts: Fronts, theta: Array, z: Array, whitener: Array) -> Fronts | None:
        """Least squares of the whitened passage, from the crossings."""
        begin, end = np.searchsorted(theta, (fronts.alpha_1 - _REACH, fronts.alpha_2 + _REACH))
        begin -= _ORDER
        middle = int(np.searchsorted(theta, 0.5 * (fronts.alpha_1 + fronts.alpha_2))) - begin
        theta = theta[begin:end]
        columns = np.zeros((5, len(theta)))
        alphas = np.array((fronts.alpha_1, fronts.alpha_2))
        for _ in range(2):
            columns[0] = z[begin:end]
            columns[1] = 1.0
            for side, part in enumerate((slice(0, middle), slice(middle, None))):
                phi = theta[part] - alphas[side]
                columns[2, part] = np.interp(phi, GRID, self._tables[side])
                columns[3 + side, part] = -np.interp(phi, GRID, self._slopes[side])
            white = filtered(whitener, columns)
            gram = white[1:] @ white[1:].T
            try:
                solution = np.linalg.solve(gram, white[1:] @ white[0])
            except np.linalg.LinAlgError:
                return None  # no sample is on one of the fronts
            alphas = alphas + solution[2:] / solution[1]
            if not np.all(np.abs(alphas - (fronts.alpha_1, fronts.alpha_2)) < _FARTHEST):
                return None
        left = float(np.mean((white[0] - solution @ white[1:]) ** 2))
        variance = left * float(np.mean(np.diag(np.linalg.inv(gram))[2:])) / float(solution[1]) ** 2
        stddev = float(np.sqrt(variance))
        return replace(fronts, alpha_1=float(alphas[0]), alpha_2=float(alphas[1]), stddev=stddev)
