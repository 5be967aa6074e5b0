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

from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

FREE_BEGIN, FREE_END = -np.pi, float(-np.radians(50.0))
"""The free belt before the patch [rad from its expected centre]."""
WINDOW_END = float(np.radians(50.0))
"""End of the window searched for fronts [rad]; it begins at FREE_END."""
NOISE_END = -np.radians(75.0)
"""Angle before which the bulge has no effect, so that the signal is noise [rad]."""
_SLOPE_REACH = np.radians(0.5)
"""Distance before and after a front over which its slope is taken [rad]."""
_CORE = np.radians(4.0)
"""Half width about the expected centre that lies in the patch [rad]."""
_SMOOTHING = np.radians(3.0)
"""Width of the running mean of the first pass, and largest distance of the final crossing from its result [rad]."""
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
    """Mean P inside the patch [m/s^2]."""
    step: float
    """Centripetal step c omega^2 [m/s^2]."""
    stddev: float = np.nan
    """Standard deviation of either front from the noise of the signal [rad]; NaN where not computed."""


def find_fronts(theta: Array, acceleration: Array, free_level: float, speed_ratio: float) -> Fronts | None:
    """Return the fronts of one passage, or None where there is no twin spike.

    Args:
        theta: wheel angle [rad] about the expected centre of the patch, increasing, over the window, shape (n,).
        acceleration: radial, positive towards the hub [m/s^2], shape (n,).
        free_level: M, mean on the free belt [m/s^2].
        speed_ratio: omega over the window / omega over the free belt.
    """
    # First with the expected core of the patch, on a smoothed signal that is robust to a rough road.
    width = max(int(len(theta) * _SMOOTHING / (theta[-1] - theta[0])), 2)
    total = np.concatenate(((0.0,), np.cumsum(acceleration)))
    smooth, places = (total[width:] - total[:-width]) / width, 0.5 * (theta[width - 1 :] + theta[: 1 - width])
    floor = _mean_between(theta, acceleration, -_CORE, _CORE)
    rough = _crossings(places, smooth, floor, free_level, speed_ratio)
    if rough is None:
        return None
    falling, rising, _ = rough
    before, after = falling[falling < 0.0], rising[rising > 0.0]
    if len(before) == 0 or len(after) == 0:
        return None
    entry, exit_ = float(before[-1]), float(after[0])
    # Then with the inner half of the patch found, the crossings nearest to those.
    quarter = 0.25 * (exit_ - entry)
    floor = _mean_between(theta, acceleration, entry + quarter, exit_ - quarter)
    fine = _crossings(theta, acceleration, floor, free_level, speed_ratio)
    if fine is None:
        return None
    falling, rising, step = fine
    alpha_1, alpha_2 = _nearest(falling, entry), _nearest(rising, exit_)
    if not max(abs(alpha_1 - entry), abs(alpha_2 - exit_)) < _SMOOTHING:
        return None
    return Fronts(alpha_1, alpha_2, floor, step)


def noise_over_slope(theta: Array, acceleration: Array, fronts: Fronts) -> float:
    """Return the standard deviation of a crossing [rad]: noise on the free belt over the mean slope of the fronts.

    It is inf where the fronts have no slope.

    Args:
        theta: wheel angle [rad] about the expected centre, increasing, from half a revolution before it on, shape (n,).
        acceleration: acceleration at those angles [m/s^2], shape (n,).
        fronts: fronts found in them.
    """
    free = slice(0, int(np.searchsorted(theta, NOISE_END)))
    noise = float(np.std(acceleration[free] - GRAVITY * np.cos(theta[free])))
    places = np.array([fronts.alpha_1, fronts.alpha_2, fronts.alpha_1, fronts.alpha_2])
    places += np.array([-_SLOPE_REACH, _SLOPE_REACH, _SLOPE_REACH, -_SLOPE_REACH])
    outer_1, outer_2, inner_1, inner_2 = np.interp(places, theta, acceleration)
    slope = float(outer_1 + outer_2 - inner_1 - inner_2) / (4.0 * _SLOPE_REACH)
    return noise / slope if slope > 0.0 else np.inf


def _mean_between(theta: Array, values: Array, begin: float, end: float) -> float:
    """Return the mean over a range of angles; NaN where it holds no sample."""
    first, last = np.searchsorted(theta, (begin, end))
    return float(np.mean(values[first:last])) if last > first else np.nan


def _nearest(places: Array, wanted: float) -> float:
    return float(places[np.argmin(np.abs(places - wanted))]) if len(places) else np.inf


def _crossings(
    theta: Array, acceleration: Array, floor: float, free_level: float, speed_ratio: float
) -> tuple[Array, Array, float] | None:
    """Return angles of falling and rising crossings, and the centripetal step; None where that is not positive."""
    step = (free_level - floor + GRAVITY * (1.0 - _MEAN_COSINE)) * speed_ratio**2
    if not step > 0.0:
        return None
    normalised = (acceleration - floor) / step - LEVEL
    outside = normalised > 0.0
    change = np.flatnonzero(outside[1:] != outside[:-1])
    before, after = normalised[change], normalised[change + 1]
    angles = theta[change] + before / (before - after) * (theta[change + 1] - theta[change])
    rises = after > 0.0
    return angles[~rises], angles[rises], step
