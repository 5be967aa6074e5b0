"""Memory of a fit: a quadratic in z for the nodes that have left the window, and how it fades."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quadratic:
    """0.5 d^T information d + gradient^T d, d = z - reference."""

    information: Array
    gradient: Array
    reference: Array
    log_likelihood: float = 0.0


def loosened(information: Array, gradient: Array, step: Array, variance: float) -> tuple[Array, Array]:
    """Return the quadratic after z has moved along `step`, shape (P,), at random with this variance."""
    column = information @ step
    gain = column * (variance / (1.0 + variance * float(column @ step)))
    return information - np.outer(gain, column), gradient - gain * float(gradient @ step)


def forgotten(information: Array, gradient: Array, index: int) -> tuple[Array, Array]:
    """Return the quadratic for the others whatever unknown `index` is."""
    column = information[:, index]
    if not column[index] > 0.0:
        return information, gradient
    gain = column / column[index]
    return information - np.outer(gain, column), gradient - gain * gradient[index]
