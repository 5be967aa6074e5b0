"""Pitch of the body on its springs, which moves load between the axles and tilts the accelerometer.

    p'' + 2 zeta w p' + w^2 p = w^2 f,    q = p + d (2 zeta / w) p'

f is the specific force, p the one whose steady pitch the body has, q the one whose steady load transfer acts; d is the
share of the dampers in the transfer.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtbtrs

from friction_curve_id.car.unknowns import Unknown

Array = NDArray[np.float64]

PITCH_UNKNOWNS = (Unknown.LOG_PITCH_FREQUENCY, Unknown.PITCH_DAMPING, Unknown.DAMPER_SHARE)
_STEPS = (0.02, 0.02, 0.05)
"""Steps of the derivatives by differences."""


@dataclass(frozen=True)
class PitchState:
    """Last two inputs and outputs before the first node, newest first [m/s^2]."""

    force: tuple[float, float] = (0.0, 0.0)
    pitch: tuple[float, float] = (0.0, 0.0)
    load: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Pitch:
    """Pitch and load transfer at the nodes, in units of the specific force [m/s^2], shape (n,)."""

    pitch: Array
    load: Array
    load_gradient: Array
    """d q / d (ln w, zeta, d), shape (3, n)."""


def pitch_of_body(force: Array, interval: float, unknowns: Array, state: PitchState) -> Pitch:
    """Return the pitch under a specific force [m/s^2], shape (n,), sampled every `interval` [s]."""
    frequency, damping, share = (float(unknowns[each]) for each in PITCH_UNKNOWNS)

    def load_of(log_frequency: float, zeta: float, part: float) -> Array:
        return _filtered(force, interval, log_frequency, zeta, part, state.force, state.load)

    pitch = _filtered(force, interval, frequency, damping, 0.0, state.force, state.pitch)
    load = load_of(frequency, damping, share)
    gradient = np.empty((3, force.size))
    for row, step in enumerate(_STEPS):
        moved = [frequency, damping, share]
        moved[row] += step
        gradient[row] = (load_of(*moved) - load) * (1.0 / step)
    return Pitch(pitch, load, gradient)


def _filtered(
    force: Array,
    interval: float,
    log_frequency: float,
    damping: float,
    share: float,
    inputs: tuple[float, float],
    outputs: tuple[float, float],
) -> Array:
    """Return the load transfer q, or the pitch p for share 0, by the trapezoidal rule (Tustin) [m/s^2], shape (n,).

    Args:
        force: specific force f [m/s^2], n >= 2 samples.
        interval: time between samples [s].
        log_frequency: ln w, w in rad/s.
        damping: zeta.
        share: d.
        inputs: forces before the first, newest first.
        outputs: results before the first, newest first.
    """
    x = 0.5 * exp(log_frequency) * interval
    zeta = min(max(damping, 0.05), 2.0)
    square, first = x * x, 2.0 * zeta * x
    scale = 1.0 / (1.0 + first + square)
    b0, b1, b2 = (square + share * first) * scale, 2.0 * square * scale, (square - share * first) * scale
    a1, a2 = 2.0 * (square - 1.0) * scale, (1.0 - first + square) * scale
    driving = np.empty((force.size, 1), order="F")
    given = driving[:, 0]
    given[:] = b0 * force
    given[1:] += b1 * force[:-1]
    given[2:] += b2 * force[:-2]
    given[0] += b1 * inputs[0] + b2 * inputs[1] - a1 * outputs[0] - a2 * outputs[1]
    given[1] += b2 * inputs[0] - a2 * outputs[0]
    band = np.ones((3, force.size), order="F")
    band[1], band[2] = a1, a2
    solution, _ = dtbtrs(band, driving, uplo="L", diag="U")
    return np.asarray(solution[:, 0])
