"""Memory of a fit: a quadratic in z for the nodes that have left the window, and how it fades."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.unknowns import Unknown

Array = NDArray[np.float64]


class _Drift(NamedTuple):
    """An unknown that leaves the model."""

    unknown: Unknown
    rate: float
    """Standard deviation of what it gains within a second, in its unit."""
    taken_along: Unknown | None = None
    """Unknown that moves by `sign` times the time since the start, so that speed or curve until now stay."""
    sign: float = 0.0


_DRIFTS = (
    _Drift(Unknown.SLOPE, 0.2, Unknown.START_SPEED, 1.0),
    _Drift(Unknown.START_SPEED, 0.05),
    _Drift(Unknown.CURVE_RATE, 0.004, Unknown.CURVE, -1.0),
)


@dataclass(frozen=True)
class Quadratic:
    """0.5 d^T information d + gradient^T d, d = z - reference."""

    information: Array
    gradient: Array
    reference: Array
    log_likelihood: float = 0.0


def drifted(information: Array, gradient: Array, stddev: Array, time: float, duration: float) -> tuple[Array, Array]:
    """Return the quadratic after its unknowns have left the model.

    Args:
        information: matrix in z, shape (P, P).
        gradient: shape (P,).
        stddev: of the prior, shape (P,).
        time: since the start [s].
        duration: over which they drift [s].
    """
    for unknown, rate, along, sign in _DRIFTS:
        if stddev[unknown] > 0.0:
            step = np.zeros_like(stddev)
            step[unknown] = 1.0 / stddev[unknown]
            if along is not None:
                step[along] = sign * time / stddev[along]
            information, gradient = loosened(information, gradient, step, rate**2 * duration)
    return information, gradient


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
