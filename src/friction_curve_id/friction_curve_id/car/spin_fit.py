"""Curve of one family through slips and frictions of wheels that spin, with what may be wrong of the car.

Robust least squares over n nodes of W wheels; unknowns with a deviation of zero are known exactly.
"""

from math import exp, hypot, log, pi, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from friction_curve_id.car.curve_family import CurveValues, Family, ShapePrior, curve_values
from friction_curve_id.car.prior import LOG_LAMBDA_MAX, LOG_MU_MAX
from friction_curve_id.curve.fitted_curve import samples_per_information

Array = NDArray[np.float64]

MU, LAMBDA, SHAPE_1, SHAPE_2, OFFSET, BIAS, LENGTH, TIMING = range(8)
"""Unknowns of a fit: ln mu_max, ln lambda_max, shape of the curve; slip of a rolling driven wheel [-], bias of the
accelerometer [m/s^2], ln of the relaxation length over that of the vehicle file, age of the acceleration against the
wheel speeds [s]."""
NODE: Final = 0.02
"""[s] over which signals are averaged."""
FEWEST: Final = 20
"""Nodes of a fit."""
NOISE, LEAST_NOISE = 0.03, 0.005
"""[-] standard deviation of the friction of a node over mu_max, as loads vary; the same by the accelerometer alone."""
BLUR: Final = 0.5
"""[-] of a change of slip within a node that its friction may be off by."""
PIECES: Final = 15.0
"""A tyre departs from its formula in so many places: a fit knows no more than from as many nodes."""
_FIRST_STEPS, _STEPS = 20, 6
"""Most evaluations of the first fit, and of those that go on from there."""


class Fit(NamedTuple):
    """A curve with the covariance of all unknowns."""

    unknowns: Array
    covariance: Array
    log_evidence: float
    misfit: float
    """RMS over mu_max [-]."""
    off: float
    """Mean of the newest over mu_max [-]."""
    noise: float
    """Standard deviation of the friction of a node by which the next fit goes [-]."""


def fit_curve(
    family: Family,
    shape: ShapePrior,
    slips: Array,
    friction: Array,
    by_bias: Array,
    of_car: Array,
    before: Fit | None = None,
) -> Fit:
    """Fit a curve to n nodes of W wheels, by the noise that the fit before has found.

    Args:
        family: formula of the curve.
        shape: prior of its shape.
        slips: slip [-] and its derivatives by LENGTH and TIMING, shape (n, 3, W).
        friction: of each wheel [-], shape (n, W).
        by_bias: its derivative by BIAS [s^2/m], shape (n,).
        of_car: standard deviations of OFFSET, BIAS, LENGTH and TIMING, shape (4,).
        before: where to begin; None: at the prior and the largest friction.
    """
    mean = np.array([LOG_MU_MAX[0], LOG_LAMBDA_MAX[0], *shape.mean, 0.0, 0.0, 0.0, 0.0])
    stddev = np.array([LOG_MU_MAX[1], LOG_LAMBDA_MAX[1], *shape.stddev, *of_car])
    free = stddev > 0.0
    count, wheels = len(friction), slips.shape[2]
    largest = float(np.abs(friction).max())
    given = hypot(NOISE * largest, LEAST_NOISE)

    def evaluate(z: Array) -> tuple[Array, CurveValues, Array]:
        p = mean.copy()
        p[free] += z * stddev[free]
        moved = slips[:, 0] + p[OFFSET] + p[LENGTH] * slips[:, 1] + p[TIMING] * slips[:, 2]
        log_peak = float(p[LAMBDA])
        return p, curve_values(family, log_peak, (float(p[SHAPE_1]), float(p[SHAPE_2])), moved / exp(log_peak)), moved

    start = mean.copy()
    start[MU] = log(max(largest, 0.05))
    z = ((start if before is None else before.unknowns)[free] - mean[free]) / stddev[free]
    # A slip that changes within its node blurs the friction where the curve is steep.
    p, curve, _ = evaluate(z)
    blurred = BLUR * NODE * np.abs(slips[:, 2]) * exp(float(p[MU] - p[LAMBDA])) * np.abs(curve.slope)
    weight = given / np.hypot(given, blurred)

    def missed(z: Array) -> Array:
        p, curve, _ = evaluate(z)
        return np.asarray(weight * (friction + (p[BIAS] * by_bias)[:, None] - exp(float(p[MU])) * curve.value))

    def residuals(z: Array, noise: float) -> Array:
        return np.concatenate([missed(z).ravel() / noise, z])

    def jacobian(z: Array, noise: float) -> Array:
        p, curve, moved = evaluate(z)
        mu_max, slope = exp(float(p[MU])), curve.slope / exp(float(p[LAMBDA]))
        rows = np.empty((count, wheels, len(p)))
        rows[..., MU], rows[..., LAMBDA] = curve.value, curve.by_log_peak - slope * moved
        rows[..., SHAPE_1], rows[..., SHAPE_2] = curve.by_shape
        rows[..., OFFSET], rows[..., BIAS] = slope, -by_bias[:, None] / mu_max
        rows[..., LENGTH], rows[..., TIMING] = slope * slips[:, 1], slope * slips[:, 2]
        scaled = (rows * weight[:, :, None]).reshape(-1, len(p)) * (-mu_max / noise * stddev)
        return np.vstack([scaled[:, free], np.eye(int(free.sum()))])

    noise = given * sqrt(wheels) if before is None else before.noise  # the wheels are told one friction
    steps = _FIRST_STEPS if before is None else _STEPS
    z = least_squares(residuals, z, jacobian, args=(noise,), loss="soft_l1", max_nfev=steps).x
    wrong = missed(z)
    rms = float(np.sqrt(np.mean(wrong**2)))
    alike = max(samples_per_information(wrong.mean(axis=1)), count / PIECES)
    noise = max(given, rms) * sqrt(alike * wheels)
    rows, off = jacobian(z, noise), residuals(z, noise)
    information = rows.T @ rows
    covariance = np.zeros((len(mean),) * 2)
    covariance[np.ix_(free, free)] = np.linalg.inv(information) * np.outer(stddev[free], stddev[free])
    log_det = float(np.linalg.slogdet(information / (2.0 * pi))[1])
    evidence = -0.5 * (float(off @ off) + log_det) - count / alike * log(noise)
    newest = float(wrong[-FEWEST:].sum() / weight[-FEWEST:].sum())
    p, _, _ = evaluate(z)
    mu_max = exp(float(p[MU]))
    return Fit(p, covariance, evidence, rms / mu_max, newest / mu_max, noise)
