"""Evidence of the other wheels: all are probably on one road, with tyres that are alike, and may be on different ones.

A wheel j is on the road of wheel i with probability p; then both have nearly the same lambda_max and mu_max:

    w_i(h) ~ L_i(h) product over j of (p P_j(h) r_ij(h) + 1 - p),    r_ij = N(ln mu_i - ln mu_j; 0, s^2) / N(...; 0, 1)

P_j is the distribution of wheel j over lambda_max, smoothed, relative to a flat one. On a split road the frictions
differ, r vanishes, and each side has its own curve.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from friction_slope.slip_position.curve_shapes import LAMBDA_MAX, SHAPES

Array = NDArray[np.float64]

SAME_ROAD: Final = 0.9
"""Probability that two wheels are on one road [-]."""
LAMBDA_STDDEV: Final = 0.07
"""Deviation of lambda_max between the tyres of a car on one road, relative [-]."""
MU_STDDEV: Final = 0.1
"""Deviation of mu_max between them, errors of load and brake gain included, relative [-]."""
_DISTANCE = np.log(LAMBDA_MAX[:, np.newaxis] / LAMBDA_MAX)
_SMOOTHING = np.exp(-0.5 * (_DISTANCE / LAMBDA_STDDEV) ** 2)
_SMOOTHING /= _SMOOTHING.sum(axis=1, keepdims=True)


def own_weights(log_weights: Array) -> Array:
    """Weights of the hypotheses by each wheel's own evidence, shape (n, H), sums of 1."""
    weights = np.exp(log_weights - log_weights.max(axis=1, keepdims=True))
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def joint_weights(own: Array, mu: Array, mu_variance: Array, braked: NDArray[np.bool_]) -> Array:
    """Weights with the evidence of the other wheels, shape (n, H), sums of 1.

    Args:
        own: by each wheel's own evidence, shape (n, H).
        mu: peak friction of each hypothesis [-], > 0, shape (n, H).
        mu_variance: its variance, shape (n, H).
        braked: wheels that have evidence, shape (n,).
    """
    n = len(own)
    if n == 1:
        return own
    marginal = own.reshape(n, LAMBDA_MAX.size, len(SHAPES)).sum(axis=2) @ _SMOOTHING
    alike = SAME_ROAD * LAMBDA_MAX.size * np.repeat(marginal, len(SHAPES), axis=1)
    log_mu, relative = np.log(mu), mu_variance / mu**2
    apart = (log_mu[:, np.newaxis] - log_mu) ** 2
    variance = np.minimum(relative[:, np.newaxis] + relative + MU_STDDEV**2, 1.0)
    ratio = np.exp(0.5 * apart * (1.0 - 1.0 / variance)) / np.sqrt(variance)
    factors = alike * ratio + (1.0 - SAME_ROAD)
    factors[:, ~braked] = 1.0
    factors[np.arange(n), np.arange(n)] = 1.0
    weights = own * factors.prod(axis=1)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
