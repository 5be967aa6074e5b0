"""Memory of a fit: a quadratic in z for the nodes that have left the window, and how it fades."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_model import recursion

Array = NDArray[np.float64]

_LOAD_CORRELATION = 0.02
"""Time over which the load of a wheel varies [s]: below 15 Hz."""


@dataclass(frozen=True)
class Quadratic:
    """0.5 d^T information d + gradient^T d, d = z - reference."""

    information: Array
    gradient: Array
    reference: Array
    spread: Array
    """What the information has to grow by, as variance of its gradient: load noise is coloured, shape (P, P)."""
    log_likelihood: float = 0.0


def loosened(information: Array, gradient: Array, step: Array, variance: float) -> tuple[Array, Array]:
    """Return the quadratic after z has moved along `step`, shape (P,), at random with this variance.

    The variance of its gradient by noise is left as it is, and so weighs more where less is known. Transformed as in
    `forgotten` it would be exact for these drifts alone, and there are more: the slips of random cars were then within
    their 95 % intervals in 59 % of an ABS stop on wet.
    """
    column = information @ step
    gain = column * (variance / (1.0 + variance * float(column @ step)))
    return information - np.outer(gain, column), gradient - gain * float(gradient @ step)


def forgotten(information: Array, gradient: Array, spread: Array, index: int) -> tuple[Array, Array, Array]:
    """Return the quadratic, and the variance of its gradient, for the others whatever unknown `index` is."""
    column = information[:, index]
    if not column[index] > 0.0:
        return information, gradient, spread
    gain = column / column[index]
    spread = spread - np.outer(gain, spread[index])
    spread = spread - np.outer(spread[:, index], gain)
    return information - np.outer(gain, column), gradient - gain * gradient[index], spread


def spread_by_load(white: Array, load_stddev: Array, interval: Array) -> Array:
    """Return the variance of the gradient that is due to the correlation of the load noise, shape (P, P).

    Noise with the correlation exp(-|t| / 0.02 s) has the covariance D R D.

    Args:
        white: C^-1 J, shape (W n, P).
        load_stddev: D, standard deviation of e by the load [rad/s^2], shape (W, n).
        interval: of the nodes [s], shape (n,).
    """
    wheels, n = load_stddev.shape
    scaled = white.reshape(wheels, n, -1) * load_stddev[:, :, np.newaxis]
    by_node = np.asfortranarray(scaled.transpose(1, 0, 2).reshape(n, -1))
    keep = np.exp(-interval[1:] / _LOAD_CORRELATION)
    earlier = recursion(keep, by_node) - by_node  # what correlates with each node before it
    cross = by_node.reshape(n * wheels, -1).T @ earlier.reshape(n * wheels, -1)
    return np.asarray(cross + cross.T)
