"""The two fronts of the twin spike by zero crossing of the normalised, detrended signal (section 8.4.4, Figure 8.19).

Both references come from the revolution itself, so neither drift of the sensor's offset nor a change of speed reaches
the fronts: the mean M on the free belt (angle -180 to -50 degrees before the patch) and the mean P inside the patch.
With gravity, M = offset + c omega_M^2 + g mean(cos), P = offset + g, and the centripetal step at the patch is

    c omega^2 = (M - P + g (1 - mean(cos))) (omega / omega_M)^2.

The normalised signal is (a - P) / (c omega^2); the fronts are where it crosses 0.6, interpolated between samples.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
FREE_BEGIN, FREE_END = -np.pi, float(-np.radians(50.0))
"""The free belt before the patch [rad from its expected centre]."""
WINDOW_END = float(np.radians(50.0))
"""End of the window searched for fronts [rad]; it begins at FREE_END."""
_CORE = np.radians(4.0)
"""Half width about the expected centre that lies in the patch [rad]."""
LEVEL = 0.6
"""Share of the centripetal step at a front: there the signal is steepest, at the very edge of the patch."""
_MEAN_COSINE = (np.sin(FREE_END) - np.sin(FREE_BEGIN)) / (FREE_END - FREE_BEGIN)


@dataclass(frozen=True)
class Fronts:
    """Both fronts of one passage."""

    alpha_1: float
    """Angle where the sensor enters the patch [rad], in the frame of `theta`."""
    alpha_2: float
    """Angle where it leaves [rad]."""
    floor: float
    """P [m/s^2]."""
    step: float
    """c omega^2 [m/s^2]."""


def find_fronts(theta: Array, acceleration: Array, free_level: float, speed_ratio: float) -> Fronts | None:
    """Fronts of one passage, or None where there is no twin spike.

    Args:
        theta: wheel angle [rad] about the expected centre of the patch, increasing, over the window, shape (n,).
        acceleration: radial, positive towards the hub [m/s^2], shape (n,).
        free_level: M, mean on the free belt [m/s^2].
        speed_ratio: omega over the window / omega over the free belt.
    """
    begin, end = np.searchsorted(theta, (-_CORE, _CORE))
    if end - begin < 2:
        return None
    # First with the expected core of the patch, then with the inner half of the patch found.
    rough = _cross(theta, acceleration, float(np.mean(acceleration[begin:end])), free_level, speed_ratio)
    if rough is None:
        return None
    quarter = 0.25 * (rough.alpha_2 - rough.alpha_1)
    begin, end = np.searchsorted(theta, (rough.alpha_1 + quarter, rough.alpha_2 - quarter))
    if end - begin < 2:
        return None
    return _cross(theta, acceleration, float(np.mean(acceleration[begin:end])), free_level, speed_ratio)


def _cross(theta: Array, acceleration: Array, floor: float, free_level: float, speed_ratio: float) -> Fronts | None:
    step = (free_level - floor + GRAVITY * (1.0 - _MEAN_COSINE)) * speed_ratio**2
    if not step > 0.0:
        return None
    normalised = (acceleration - floor) / step - LEVEL
    centre = int(np.searchsorted(theta, 0.0))
    outside = normalised > 0.0
    before, after = np.flatnonzero(outside[:centre]), np.flatnonzero(outside[centre:])
    if len(before) == 0 or len(after) == 0 or after[0] == 0 or before[-1] == centre - 1:
        return None
    return Fronts(
        alpha_1=_zero(theta, normalised, int(before[-1])),
        alpha_2=_zero(theta, normalised, centre + int(after[0]) - 1),
        floor=floor,
        step=step,
    )


def _zero(theta: Array, normalised: Array, k: int) -> float:
    """Angle of the zero between samples k and k + 1."""
    share = normalised[k] / (normalised[k] - normalised[k + 1])
    return float(theta[k] + share * (theta[k + 1] - theta[k]))
