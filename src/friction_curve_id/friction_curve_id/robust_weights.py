"""Weights of samples that disagree with the model: one for noise, less for outliers.

The newest samples weigh as in Huber's loss, threshold / |residual|: convex, so a true jump wins once enough samples
confirm it. Older samples, whose neighbours on both sides have spoken, weigh (threshold / |residual|)^4: an outlier
ends up with next to no influence.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEWEST = 10
"""Samples that count as new."""


def robust_weights(squared: Array, threshold: float, newest: int = NEWEST) -> Array:
    """Weights in (0, 1], shape (n,), of squared residuals [standard deviations squared], oldest first.

    Args:
        squared: shape (n,).
        threshold: residuals up to this many standard deviations weigh 1.
        newest: so many at the end count as new.
    """
    ratio = np.minimum(threshold**2 / np.maximum(squared, 1e-30), 1.0)
    weights = ratio * ratio
    first = max(len(weights) - newest, 0)
    weights[first:] = np.sqrt(ratio[first:])
    return weights
