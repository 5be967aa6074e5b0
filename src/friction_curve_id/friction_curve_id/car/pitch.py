"""Pitch of the body on its springs, which moves load between the axles and tilts the accelerometer.

    p'' + 2 zeta w p' + w^2 p = w^2 f,    q = p + d (2 zeta / w) p'

f is the specific force, p the one whose steady pitch the body has, q the one whose steady load transfer acts; d is the
share of the dampers in the transfer.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.pitch_filter import filtered
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
    given = force.tolist()

    def load_of(log_frequency: float, zeta: float, part: float) -> Array:
        return np.array(filtered(given, interval, log_frequency, zeta, part, state.force, state.load))

    pitch = np.array(filtered(given, interval, frequency, damping, 0.0, state.force, state.pitch))
    load = load_of(frequency, damping, share)
    gradient = np.empty((3, force.size))
    for row, step in enumerate(_STEPS):
        moved = [frequency, damping, share]
        moved[row] += step
        gradient[row] = (load_of(*moved) - load) * (1.0 / step)
    return Pitch(pitch, load, gradient)
