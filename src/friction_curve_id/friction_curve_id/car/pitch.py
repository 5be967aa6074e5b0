"""Pitch of the body on its springs, which moves load between the axles and tilts the accelerometer.

    p'' + 2 zeta w p' + w^2 p = w^2 f,    q = p + d (2 zeta / w) p'

f is the specific force, p the one whose steady pitch the body has, q the one whose steady load transfer acts; d is the
share of the dampers in the transfer. Discretised by the trapezoidal rule (Tustin).

The filter is a plain loop: importing scipy.signal takes longer than all else that a node or a command does at start.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

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
    pitch = _filtered(force, interval, frequency, damping, 0.0, state.force, state.pitch)
    load = _filtered(force, interval, frequency, damping, share, state.force, state.load)
    gradient = np.empty((3, force.size))
    for row, step in enumerate(_STEPS):
        moved = [frequency, damping, share]
        moved[row] += step
        stepped = _filtered(force, interval, moved[0], moved[1], moved[2], state.force, state.load)
        gradient[row] = (stepped - load) * (1.0 / step)
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
    """Filter; `inputs` and `outputs` are those before the first, newest first."""
    x = 0.5 * exp(log_frequency) * interval
    zeta = min(max(damping, 0.05), 2.0)
    square, first = x * x, 2.0 * zeta * x
    scale = 1.0 / (1.0 + first + square)
    b0, b1, b2 = (square + share * first) * scale, 2.0 * square * scale, (square - share * first) * scale
    a1, a2 = 2.0 * (square - 1.0) * scale, (1.0 - first + square) * scale
    later = b1 * inputs[0] + b2 * inputs[1] - a1 * outputs[0] - a2 * outputs[1]
    latest = b2 * inputs[0] - a2 * outputs[0]
    filtered: list[float] = []
    for taken in force.tolist():
        given = later + b0 * taken
        later = latest + b1 * taken - a1 * given
        latest = b2 * taken - a2 * given
        filtered.append(given)
    return np.array(filtered)
