"""The slips of now by the fit of some milliseconds ago, and whether they are beyond the peak."""

from math import exp, expm1, sqrt

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import LEAST_RELAXATION, SPEED_UNKNOWNS
from friction_curve_id.car.evidence import normal_probability
from friction_curve_id.car.fit import CurveFit
from friction_curve_id.car.unknowns import SHARED, Unknown

Array = NDArray[np.float64]

_LASTING_ERRORS = 1.5
"""Deviation of a slip over that of the fit [-]: errors of the model last longer than those of the load."""


def present_slip(
    car: CarConstants,
    fit: CurveFit,
    ahead: float,
    changed: float,
    speed: Array,
    yaw_rate: float,
    factor: float,
    floor: float,
) -> tuple[Array, Array, list[float]]:
    """Return the slip of each wheel [-] and its variance, shapes (W,), and the probability that it is beyond the peak.

    Lateral slips are those of the last node.

    Args:
        car: nominal values.
        fit: after its last step.
        ahead: time since its last node [s].
        changed: integral of the measured acceleration since then [m/s].
        speed: present wheel speeds [rad/s], shape (W,).
        yaw_rate: [rad/s].
        factor: by which the deviation of lambda_max counts more than the fit says.
        floor: least relative deviation of lambda_max.
    """
    p, moved = fit.unknowns, fit.moved
    wheels = speed.size
    own = (changed - p[Unknown.ACCELEROMETER_OFFSET] * ahead) / (1.0 + p[Unknown.ACCELEROMETER_SCALE])
    velocity = max(float(moved.speed[-1]) + own - p[Unknown.SLOPE] * ahead, 0.5)
    ground = np.maximum(velocity - yaw_rate * car.half_track * car.left[:, 0], 0.5)
    rolling = car.radius[:, 0] * speed / ground
    time = fit.newest + ahead
    slip = 1.0 - rolling + p[SHARED:] + car.left[:, 0] * (p[Unknown.CURVE] + p[Unknown.CURVE_RATE] * time)
    # The force of a tyre follows its relaxed slip, from that of the last node on.
    x = max(velocity * ahead / max(float(p[Unknown.RELAXATION_LENGTH]), LEAST_RELAXATION), 1e-6)
    keep, decay = exp(-x), -expm1(-x) / x
    relaxed = keep * moved.relaxed[:, -1] + (decay - keep) * moved.slip[:, -1] + (1.0 - decay) * slip
    limit = exp(p[Unknown.LOG_LAMBDA_MAX])
    rows = np.zeros((wheels, p.size))
    rows[:, SPEED_UNKNOWNS] = np.outer(rolling / ground, moved.speed_gradient[:, -1])
    rows[:, Unknown.CURVE] = car.left[:, 0]
    rows[:, Unknown.CURVE_RATE] = car.left[:, 0] * time
    rows[range(wheels), SHARED + np.arange(wheels)] = 1.0
    products = rows @ fit.covariance
    of_slip = (products * rows).sum(axis=1)
    # That of the slip less lambda_max.
    of_limit = limit * factor
    peak = Unknown.LOG_LAMBDA_MAX
    beside = of_slip + of_limit * (of_limit * fit.covariance[peak, peak] - 2.0 * products[:, peak])
    across_variance: Array | float = 0.0
    if fit.tyres.across is not None:
        across, stddev = fit.tyres.across[:, -1], np.broadcast_to(fit.tyres.across_stddev, moved.slip.shape)[:, -1]
        slip, relaxed = np.hypot(slip, across), np.hypot(relaxed, across)
        across_variance = (stddev * across / np.maximum(relaxed, 1e-6)) ** 2
    variance = beside + (floor * limit) ** 2 + across_variance
    beyond = [normal_probability(float((relaxed[each] - limit) / sqrt(variance[each]))) for each in range(wheels)]
    return slip, _LASTING_ERRORS**2 * of_slip, beyond
