"""Weights of residuals that disagree with the model: one for noise, next to nothing for outliers."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def robust_weights(squared: Array, threshold: float) -> Array:
    """Weights min(1, threshold / |residual|)^4, shape (n,), of squared residuals [standard deviations squared]."""
    ratio = np.minimum(threshold**2 / np.maximum(squared, 1e-30), 1.0)
    return np.asarray(ratio * ratio)


def robust_cost(squared: Array, threshold: float) -> Array:
    """Cost that belongs to `robust_weights`, shape (n,): squared / 2, at most threshold^2."""
    ratio = np.minimum(threshold**2 / np.maximum(squared, 1e-30), 1.0)
    return np.asarray(np.where(ratio < 1.0, threshold**2 * (1.0 - 0.5 * ratio), 0.5 * squared))


def huber_weights(squared: Array, threshold: float) -> Array:
    """Weights min(1, threshold / |residual|), shape (n,): convex, so that many large residuals together still count."""
    return np.asarray(np.minimum(threshold / np.sqrt(np.maximum(squared, 1e-30)), 1.0))


def huber_cost(squared: Array, threshold: float) -> Array:
    """Cost that belongs to `huber_weights`, shape (n,)."""
    size = np.sqrt(squared)
    return np.asarray(np.where(size > threshold, threshold * (size - 0.5 * threshold), 0.5 * squared))
