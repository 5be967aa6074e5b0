"""Homogeneous surface check: friction used by each wheel against the common curve.

    mu_used = (J omega_dot + kappa T + T_drag) / (r Fz)

One curve for two roads lies between them. Where the road changes during a braking, what the wheels use falls below the
curve or rises above it from then on; where the sides of the car are on different roads, one side uses more than the
curve says and the other less. Both are ratios of means over time, in which the load that the road's unevenness varies
averages out.
"""

from math import exp, hypot, inf, isnan, log, nan

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_constants import CarConstants
from friction_curve_id.car.car_model import Motion, brake_gains
from friction_curve_id.car.combined_slip import TyreSlips
from friction_curve_id.car.node_signals import Nodes
from friction_curve_id.car.unknowns import Unknown

Array = NDArray[np.float64]

NEWEST = 0.1
"""Time over which the newest friction is taken [s]."""
MOST_CHANGE = 0.07
"""Change of ln of used over fitted friction on one road: random cars of another plant stay below 0.1, mostly 0.06."""
STILL_CHANGED = 0.04
"""The same once it has been more: the curve itself goes over to the new road, which makes the change look smaller."""
MOST_DIFFERENT, STILL_DIFFERENT = 9.0, 4.0
"""chi^2 of one degree of freedom that the sides of the car are not on one road, and once it has been more."""
LASTING, _STEP = 0.07, 0.02
"""Time with more than that after which it is no bump, and the longest of it that a step of the fits stands for [s]."""
_LEAST_TIME = 0.1
"""Least time of what it is compared with [s], of all wheels together."""
_LEAST_AT_PEAK = 0.04
"""The same near the peak."""
_LEAST_ALONG = 0.1
"""Least share of a force along its wheel by which it is found from that [-]."""
_LEAST_SHARE = 0.4
"""Least share of mu_max at which friction is compared: below, the slope of the curve and the speed decide."""
_AT_PEAK = 0.9
"""Share of mu_max from which friction tells of the peak itself."""
_NEWEST_AT_PEAK = 0.15
"""Time over which that is taken [s]: some swings of the load, and not much of the road before."""
MOST_MISFIT = 0.05
"""Most ln of used over fitted friction there: on one road it is less in 97 % of the time."""
STILL_MISFIT = 0.025
"""The same once it has been more."""
_MOST_SPIN = 0.5
"""Most torque that speeds a wheel up or down, over that of its tyre: it is late by what nobody knows."""


def used_and_fitted(
    car: CarConstants, nodes: Nodes, moved: Motion, tyres: TyreSlips, torque: Array, unknowns: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return friction used, that of the curve at the slips, and where they can be compared; shape (W, n) each.

    In a curve both are those of the whole force, of which the brake shows the part along the wheel.

    Args:
        car: nominal values.
        nodes: measured signals.
        moved: their motion.
        tyres: their slips and frictions.
        torque: brake torque at nominal gain [N m], shape (W, n).
        unknowns: shape (SHARED + W,).
    """
    p = unknowns
    share, along = tyres.curve.value, np.maximum(tyres.along, _LEAST_ALONG)
    inertia = car.inertia * exp(float(p[Unknown.LOG_INERTIA]))
    spinning = inertia * nodes.wheel_acceleration
    acting = brake_gains(car, nodes, p) * torque + p[Unknown.ENGINE_DRAG] * car.driven + spinning
    used = acting / (car.radius * np.maximum(moved.load, 1.0) * along)
    fitted = exp(float(p[Unknown.LOG_MU_MAX])) * share
    steady = np.abs(spinning) < _MOST_SPIN * fitted * along * car.radius * moved.load
    told = nodes.turning & steady & (share * along > _LEAST_SHARE)
    return used, fitted, np.asarray(told)


def change_of_friction(used: Array, fitted: Array, time: Array) -> float:
    """Return ln of used over fitted friction in the newest time over that of before; NaN where there is too little."""
    newest = time > time[-1] - NEWEST
    return _log_ratio(used[:, newest], fitted[:, newest], time) - _log_ratio(used[:, ~newest], fitted[:, ~newest], time)


def misfit_at_peak(used: Array, fitted: Array, mu_max: float, time: Array) -> float:
    """Return ln of used over fitted friction near the peak in the newest time; NaN where there is too little.

    Where two roads have much the same curve below their peaks, only this shows the old one in the curve of the new one.
    """
    near = (fitted > _AT_PEAK * mu_max) & (time > time[-1] - _NEWEST_AT_PEAK)
    return _log_ratio(used * near, fitted * near, time, _LEAST_AT_PEAK)


def difference_of_sides(used: Array, fitted: Array, left: Array, time: Array) -> float:
    """Return ln of used over fitted friction of the left wheels over that of the right; NaN where there is too little.

    Args:
        used: shape (W, n).
        fitted: shape (W, n).
        left: +1 for a wheel on the left, -1 on the right, shape (W, 1).
        time: of the samples [s], shape (n,).
    """
    sides = [left[:, 0] * sign > 0.0 for sign in (1.0, -1.0)]
    if not all(side.any() for side in sides):
        return nan
    ratios = [_log_ratio(used[side], fitted[side], time) for side in sides]
    return ratios[0] - ratios[1]


def difference_by_tyres(fitted: Array, left: Array, deviations: Array) -> float:
    """Return the standard deviation of difference_of_sides on one road.

    Args:
        fitted: friction of the curve, zero where it is not compared, shape (W, n).
        left: +1 for a wheel on the left, -1 on the right, shape (W, 1).
        deviations: relative ones of the friction of each wheel, by its tyre alone, and by its load, which is that of
            both wheels of a side; the signs of these are those of the loads, shape (2, W).
    """
    of_wheel = fitted.sum(axis=1)
    of_side = np.where(left[:, 0] > 0.0, of_wheel[left[:, 0] > 0.0].sum(), of_wheel[left[:, 0] < 0.0].sum())
    share = of_wheel / np.maximum(of_side, 1e-9)
    own, by_load = deviations
    return max(hypot(float(np.sqrt(((share * own) ** 2).sum())), float((left[:, 0] * share) @ by_load)), 1e-6)


def _log_ratio(used: Array, fitted: Array, time: Array, least_time: float = _LEAST_TIME) -> float:
    interval = float(time[-1] - time[0]) / max(time.size - 1, 1)
    if np.count_nonzero(fitted) * interval < least_time:
        return nan
    return log(max(float(used.sum()), 1e-3) / float(fitted.sum()))


class RoadWatch:
    """Says whether the wheels are on one road.

    That the sides of the car are on different ones counts until the end of the braking once it has lasted; where the
    road has changed, the curve begins anew.

    While nothing is told of the newest friction, as between two rises of the pressure, what was found before holds.
    """

    def __init__(self) -> None:
        """Begin with the braking."""
        self._updated, self._lasted = -inf, 0.0
        self._changed = self._different = self._misfits = False
        self._lasting = ""

    @property
    def changes(self) -> bool:
        """Whether the newest friction is not that of the curve: the curve is of neither road."""
        return self._changed and not self._different

    @property
    def changed(self) -> bool:
        """Whether another road has lasted: the curve is to begin anew."""
        return self.changes and self._lasted >= LASTING

    def update(self, used: Array, fitted: Array, left: Array, time: Array, misfit: float, deviations: Array) -> str:
        """Return what speaks against one road, empty where nothing does. Arguments as above, after a step of a fit.

        `misfit`: see misfit_at_peak, NaN where there is too little; `deviations`: see difference_by_tyres.
        """
        change, difference = change_of_friction(used, fitted, time), difference_of_sides(used, fitted, left, time)
        difference = (difference / difference_by_tyres(fitted, left, deviations)) ** 2
        change_shows, difference_shows = abs(change) > MOST_CHANGE, difference > MOST_DIFFERENT
        if not isnan(change):
            self._changed = change_shows or (self._changed and abs(change) > STILL_CHANGED)
        if not isnan(difference):
            self._different = difference_shows or (self._different and difference > STILL_DIFFERENT)
        if not isnan(misfit):
            self._misfits = abs(misfit) > (STILL_MISFIT if self._misfits else MOST_MISFIT)
        found = ""
        if self._different:
            found = "the sides of the car are on different roads: waiting for one road"
        elif self._changed:
            found = "the road has changed: the curve begins anew"
        since = min(float(time[-1]) - self._updated, _STEP)
        self._updated = float(time[-1])
        if not found:
            self._lasted = 0.0
        elif change_shows or (difference_shows and not isnan(change)):
            self._lasted += since
        if self._lasted >= LASTING:
            self._lasting = found if self._different else ""
        if not found and self._misfits:
            found = "waiting for the curve to follow the newest friction near the peak"
        return self._lasting or found
