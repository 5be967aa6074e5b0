"""Change of surface: an axle on a road with much less grip restarts the fit within the braking.

A wheel that comes from dry to snow dives, and stands 30 ms later. What it uses on the way, kappa T + J omega_dot +
T_drag, is a sixth of the curve's friction at its slip, on either side of the axle alike. Nothing else is: a wheel that
dives on its own road uses what the curve says, wrong gains and inertias make a tenth, bumps are shorter, and a split
road or a sensor that fails shows at one side.
"""

from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Motion
from vehicle_models.physical_bounds import ICE_FRICTION

Array = NDArray[np.float64]

_MUCH_LESS = 0.6
"""Of the curve's friction, below which it is that of another road."""
_LASTS, _NODES = 0.02, 3
"""Time [s], and at least so many nodes, of the newest that must show it: a wheel that dives has no more before it
stands."""
_NEWEST = 0.06
"""Time within which they lie [s]."""
_SOME = 0.2
"""Least share of it that is missing in the mean since the road has changed."""
_LEAST_SHARE = 0.4
"""Least share of mu_max at which friction is compared: below, the slope of the curve and the speed decide."""
_SLOW = 0.85
"""Slip from which the acceleration of a wheel is noise, as teeth come slowly, or it stands against its brake."""
_LEAST_SPEED = 8.0
"""Of the car [m/s]; below it slips are vague, and wheels stand within a sample or two."""

_LATER = 0.01
"""By so much the wheels of the other axle may come later to another road than their distance says [s]."""
_DELAY, _LATE_SHARE = 0.015, 0.25
"""A torque that may be wrong by this share of the tyre's does not tell, if its time is wrong by so much [s]."""


class NewRoad(NamedTuple):
    """An axle that has come to another road."""

    wheels: NDArray[np.bool_]
    """Those that are on it, shape (W,)."""
    known_until: float
    """The last time at which they were seen to be on the old road [s]."""
    since: float
    """The first time at which they were seen to be on the new one [s]."""


def told_of_roads(
    car: CarConstants, moved: Motion, fitted: Array, mu_max: float, torque_rate: Array
) -> NDArray[np.bool_]:
    """Return the nodes that tell one road from another, shape (W, n).

    Args:
        car: nominal values.
        moved: motion at the nodes.
        fitted: friction of the curve at the slips, shape (W, n).
        mu_max: of the curve [-].
        torque_rate: derivative of the brake torque [N m/s], shape (W, n).
    """
    comparable = (fitted > _LEAST_SHARE * mu_max) & (moved.slip < _SLOW) & (moved.speed > _LEAST_SPEED)
    # A wheel that comes back uses less than its curve says by how much its tyre is late, which is not well known.
    comparable &= moved.slip >= moved.relaxed
    # The torque is of another moment than the wheel speed, by what is not known of its delay.
    late = np.abs(torque_rate) * _DELAY < _LATE_SHARE * fitted * car.radius * moved.load
    return np.asarray(comparable & late)


def axle_on_new_road(
    car: CarConstants, time: Array, used: Array, fitted: Array, told: NDArray[np.bool_]
) -> NewRoad | None:
    """Return an axle that has come to another road; None where none has.

    Args:
        car: nominal values.
        time: of the nodes [s], shape (n,).
        used: friction that the wheels have used, shape (W, n).
        fitted: that of the curve at their slips, shape (W, n).
        told: nodes that tell, shape (W, n).
    """
    for front in (1.0, 0.0):
        wheels = car.front[:, 0] == front
        found = [_change(time, used[each], fitted[each], told[each]) for each in np.flatnonzero(wheels)]
        if len(found) > (1 if wheels.size > 1 else 0) and all(isfinite(since) for _, since in found):
            return NewRoad(wheels, min(known for known, _ in found), min(since for _, since in found))
    return None


def friction_there(road: NewRoad, time: Array, used: Array) -> float:
    """Return about which friction another road gives.

    Args:
        road: what was found.
        time: of the nodes [s], shape (n,).
        used: friction that the wheels have used, zero where it tells nothing, shape (W, n).
    """
    newest = used[road.wheels, int(np.searchsorted(time, road.since)) :]
    return max(float(np.median(newest[newest > 0.0])), ICE_FRICTION) if (newest > 0.0).any() else ICE_FRICTION


def silenced(until: Array, road: NewRoad, car: CarConstants, wheelbase: float, time: Array, speed: Array) -> Array:
    """Return until when each wheel says nothing of another road [s], shape (W, 1): it is not there yet.

    Args:
        until: the same, so far.
        road: what was found.
        car: nominal values.
        wheelbase: [m].
        time: of the nodes [s], shape (n,).
        speed: of the car at them [m/s], shape (n,).
    """
    until = until.copy()
    until[road.wheels] = road.since
    if not road.wheels[car.front[:, 0] == 0.0].any():
        first = int(np.searchsorted(time, road.since))
        until[~road.wheels] = road.since + _way_of_wheelbase(wheelbase, time[first:], speed[first:])
    return until


def _way_of_wheelbase(wheelbase: float, time: Array, speed: Array) -> float:
    """Return how long the rear wheels take [s] to where the front ones were at the first of these times [s]."""
    slows = max(float(speed[0] - speed[-1]) / max(float(time[-1] - time[0]), 1e-3), 0.0)
    way = min(wheelbase / float(speed[0]), 1.0)
    return way * (1.0 + 0.5 * slows * way / float(speed[0])) + _LATER


def _change(time: Array, used: Array, fitted: Array, told: NDArray[np.bool_]) -> tuple[float, float]:
    """Return until when a wheel was seen to grip as the curve says, and since when much less [s]; NaN: it does."""
    at = np.flatnonzero(told)
    if at.size < _NODES or time[at[-_NODES]] < time[-1] - _NEWEST:
        return nan, nan
    used, fitted = used[at], fitted[at]
    newest = max(int(np.count_nonzero(time[at] > time[at[-1]] - _LASTS)), _NODES)
    if not float(used[-newest:].sum()) < _MUCH_LESS * float(fitted[-newest:].sum()):
        return nan, nan
    # What is missing adds up backwards as far as the new road goes, and is lost again before.
    missing = np.cumsum((1.0 - used / fitted - _SOME)[::-1])
    first = at.size - 1 - int(np.argmax(missing))
    return float(time[at[first - 1]]) if first else -inf, float(time[at[first]])
