"""Fits by the chapter's methods to the friction samples of one run."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from benchmarks.identification.printed_rml import CovarianceRML
from benchmarks.protocol import CORNER
from friction_curve_id.chapter.curve_fitting import CurveFit
from friction_curve_id.chapter.friction_samples import FrictionPoint, FrictionSamples, FrictionSource
from friction_curve_id.curve.fitted_curve import FittedCurve
from friction_curve_id.interface import Sample
from friction_curve_id.methods import CHAPTER_METHODS

Array = NDArray[np.float64]

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
