"""Last road torque: torque transmitted while the wheel slipped, the reference where slip is uncertain.

Slip has a standard deviation that grows as 1/v. At the end of a stop it no longer shows whether a wheel is near its
peak, but how it last slipped does: r Fx = T - J a / r, from (2.15) with a the deceleration of the circumference.
"""

from math import inf, isfinite, nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_KEPT: Final = 15.0
"""[m] for which it counts after the last release; another road comes with the distance."""
_TRIMS: Final = 60.0
"""[m] for which a torque that is still the same may be trimmed: on snow a wheel creeps from its peak for 50 m."""
_SAME: Final = 1.25
"""Of it: up to there it is the same. Beyond 15 m a trim takes no more than that from a brake on another road."""
_OTHER: Final = 1.5
"""Of it: a brake that has as much is on another road."""
_COMES_BACK: Final = 0.015
"""Of the car's speed: a wheel that gains as much once it is trimmed had slipped; a tyre that grips gives far less."""
_AT_ONCE: Final = round(0.25 * NANOSECONDS)
"""[ns] after a trim in which it does."""
_ENOUGH: Final = 0.85
"""Of it: a tyre that slides gives 0.7 to 0.9 of the peak's, so what is held is less than a quarter below the peak."""
_TRIMMED: Final = 0.95
"""Of it: down to there the torque may be taken back without a release's slip."""


class RoadTorque:
    """Follows the releases of one wheel."""

    def __init__(self, radius: float, inertia: float) -> None:
        """Choose a wheel of effective radius [m] and inertia [kg m^2]."""
        self._spin = inertia / radius
        self.reset()

    def reset(self) -> None:
        """Forget it, as when a braking is over."""
        self._torque = nan
        """What the road gave [N m]; for how far it counts depends on what it is for."""
        self._since = 0.0
        self._released = False
        self._stamp: int | None = None
        self._lowered: int | None = None
        self._gained = 0.0

    def update(
        self, stamp: int, released: bool, trimmed: bool, torque: float, deceleration: float, car_speed: float
    ) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            released: whether the brake is released on evidence that the wheel slips.
            trimmed: whether it is lowered a little because the torque says so.
            torque: of the brake [N m].
            deceleration: of the wheel's circumference [m/s^2], NaN where unknown.
            car_speed: [m/s], NaN where unknown.
        """
        dt = 0.0 if self._stamp is None else (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        if car_speed > 0.0:
            self._since += car_speed * dt
        self._watch_trim(stamp, trimmed, dt, deceleration, car_speed)
        if released and isfinite(deceleration):
            road = torque - self._spin * deceleration
            self._torque = max(road, self._torque) if self._released and isfinite(self._near) else road
            self._since = 0.0
        elif self._since > _TRIMS or (self._since > _KEPT and torque > _OTHER * self._torque):
            self._torque = nan
        self._released = released

    def _watch_trim(self, stamp: int, trimmed: bool, dt: float, deceleration: float, car_speed: float) -> None:
        """See whether a wheel comes back from a trim: it had slipped, and the road still gives what it gave."""
        if trimmed:
            self._gained = 0.0 if self._lowered is None else self._gained
            self._lowered = stamp
        if self._lowered is None:
            return
        if stamp - self._lowered > _AT_ONCE or not isfinite(deceleration + car_speed):
            self._lowered = None
            return
        self._gained = max(self._gained - deceleration * dt, 0.0)
        if self._gained > _COMES_BACK * car_speed:
            self._since, self._lowered = 0.0, None

    @property
    def is_known(self) -> bool:
        """Whether the wheel has slipped within the last 60 m."""
        return isfinite(self._torque)

    @property
    def _near(self) -> float:
        """What the road gave [N m], NaN where that was too far back."""
        return self._torque if self._since <= _KEPT else nan

    def is_near(self, torque: float) -> bool:
        """Whether a torque [N m] is near what the road gave, or above it."""
        return torque >= _ENOUGH * self._near

    def may_fall(self, torque: float) -> bool:
        """Whether a torque [N m] may be lowered and stays near what the road gave."""
        most = inf if self._since <= _KEPT else _SAME * self._torque
        return _TRIMMED * self._torque <= torque <= most

    def lacks(self, torque: float) -> float:
        """Return by how much a torque [N m] is below what the road gave [N m], >= 0, 0 where that is not known."""
        return max(self._near - torque, 0.0) if isfinite(self._near) else 0.0

    def is_reached(self, torque: float) -> bool:
        """Whether a torque [N m] is what the road gave, or more."""
        return torque >= self._near
