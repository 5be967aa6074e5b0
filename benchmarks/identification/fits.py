"""Curve fits of the chapter by name, on friction samples; among them RML in its covariance form.

    K = P xi / (1 + xi^T P xi),    theta += K epsilon,    P -= K xi^T P

in theta itself, on the step (8.10), without extra gain. `friction_curve_id` ships another form, which cannot diverge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from benchmarks.protocol import CORNER
from friction_curve_id.chapter.curve_fitting import CurveFit
from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource
from friction_curve_id.chapter.maximum_likelihood import initial_theta
from friction_curve_id.curve.burckhardt_curve import THETA_HIGH, THETA_LOW, BurckhardtCurve
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import Sample
from friction_curve_id.methods import CHAPTER_METHODS
from vehicle_models import burckhardt

Array = NDArray[np.float64]


class CovarianceRML:
    """RML of section 8.3.1.1 in covariance form; a CurveFit."""

    def __init__(self, covariance: float = 1.0) -> None:
        """Start P at `covariance` times the unit matrix: the chapter names no other."""
        self._covariance = covariance
        self._theta, self._p = np.zeros(3), np.eye(3)

    def start(self, slips: Array, frictions: Array) -> None:
        """Begin with theta(0) by (8.11) from the first samples, shapes (n,)."""
        self._theta = initial_theta(slips, frictions)
        self._p = self._covariance * np.eye(3)

    def add(self, slip: float, friction: float) -> None:
        """Take one more sample."""
        xi = burckhardt.gradient(self._theta, slip)
        gain = self._p @ xi / (1.0 + float(xi @ self._p @ xi))
        error = friction - float(burckhardt.friction(self._theta, slip))
        self._theta = np.clip(self._theta + gain * error, THETA_LOW, THETA_HIGH)
        self._p = self._p - np.outer(gain, xi @ self._p)

    def curve(self) -> FittedCurve:
        """The curve so far; the chapter gives no deviation."""
        return FittedCurve(BurckhardtCurve(), self._theta, np.full((3, 3), np.nan))


INITIAL_SAMPLES = 20
"""Samples that RML and RLS start from, section 8.3.2."""
FITS: Mapping[str, Callable[[], CurveFit]] = {**CHAPTER_METHODS, "rml_covariance": CovarianceRML}
"""The chapter's methods as shipped, and RML as it is usually written."""


def friction_points(samples: Iterable[Sample], source: FrictionSource) -> tuple[Array, Array]:
    """Slips and frictions of one run, shapes (samples - 1,); fewer where samples were refused."""
    maker = FrictionSamples(CORNER, source)
    points = [point for point in map(maker.update, samples) if isinstance(point, FrictionPoint)]
    slips, frictions = np.array([(point.slip, point.mu) for point in points]).T
    return slips, frictions


def begun(method: str, slips: Array, frictions: Array) -> CurveFit:
    """Return a fit by `method`, begun with the first 20 samples."""
    fit = FITS[method]()
    fit.start(slips[:INITIAL_SAMPLES], frictions[:INITIAL_SAMPLES])
    return fit


def completed(fit: CurveFit, slips: Array, frictions: Array) -> FittedCurve:
    """Return the curve after the samples that follow the first 20."""
    for slip, friction in zip(slips[INITIAL_SAMPLES:], frictions[INITIAL_SAMPLES:], strict=True):
        fit.add(float(slip), float(friction))
    return fit.curve()
