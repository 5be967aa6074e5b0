"""Whether an axle has come to a road with much more or less grip, and when: the fit then begins anew within the braking.

A wheel that comes from dry to snow dives, and stands 30 ms later. What it uses on the way, kappa T + J omega_dot + T_drag,
is a sixth of the curve's friction at its slip, on either side of the axle alike. Nothing else is: a wheel that dives on
its own road uses what the curve says, wrong gains and inertias make a tenth, bumps are shorter, and a split road or a
sensor that fails shows at one side.
"""

from math import log, nan

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_model import CarConstants, Motion

Array = NDArray[np.float64]

_MUCH = log(1.6)
"""Change of ln of used over fitted friction that is another road."""
_SOME = log(1.25)
"""The same from where on the nodes before belong to it."""
_NODES = 3
"""Newest nodes of each wheel that must show it: a wheel that dives has no more before it stands."""
_NEWEST = 0.06
"""Time within which they lie [s]."""
_LEAST_SHARE = 0.4
"""Least share of mu_max at which friction is compared: below, the slope of the curve and the speed decide."""
_STANDS = 0.95
"""Slip from which a wheel may stand. One that stood for a part of its time would seem to use more than it does."""
_LEAST_SPEED = 5.0
"""Of the car [m/s]; below it slips are vague, and wheels stand within a sample or two."""
_AT_LEAST = 1e-3
"""Least friction whose logarithm is taken."""


def told_of_roads(moved: Motion, fitted: Array, mu_max: float) -> NDArray[np.bool_]:
    """Return the nodes that tell one road from another, shape (W, n)."""
    comparable = (fitted > _LEAST_SHARE * mu_max) & (moved.slip < _STANDS)
    return np.asarray(comparable & (moved.speed > _LEAST_SPEED))


def axle_on_new_road(
    car: CarConstants, time: Array, used: Array, fitted: Array, told: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], float]:
    """Return the wheels that have come to another road, shape (W,), and since when [s]; none and NaN where none has.

    Args:
        car: nominal values.
        time: of the nodes [s], shape (n,).
        used: friction that the wheels have used, shape (W, n).
        fitted: that of the curve at their slips, shape (W, n).
        told: nodes that tell, shape (W, n).
    """
    found = np.zeros(car.wheels, dtype=bool)
    newest = time > time[-1] - _NEWEST
    for front in (1.0, 0.0):
        axle = np.flatnonzero(car.front[:, 0] == front)
        since = [_since(time, used[each], fitted[each], told[each] & newest) for each in axle]
        signs = {sign for _, sign in since}
        if len(axle) > 1 and signs in ({1}, {-1}):
            found[axle] = True
            return found, min(begin for begin, _ in since)
    return found, nan


def _since(time: Array, used: Array, fitted: Array, told: NDArray[np.bool_]) -> tuple[float, int]:
    """Return since when a wheel is on another road [s], and whether it grips more (1) or less (-1); 0: on the same."""
    at = np.flatnonzero(told)
    if at.size < _NODES:
        return nan, 0
    ratio = np.log(np.maximum(used[at], _AT_LEAST) / fitted[at])
    off = ratio[-_NODES:]
    sign = 1 if off.min() > _MUCH else -1 if off.max() < -_MUCH else 0
    if sign == 0:
        return nan, 0
    before = np.flatnonzero(sign * ratio < _SOME)
    first = int(before[-1]) + 1 if before.size else 0
    return float(time[at[first]]), sign
