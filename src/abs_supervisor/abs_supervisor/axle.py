"""Axle: how much of the driver's pressure one of its wheels may have, given what the other needs.

Select-low: both get the pressure of the wheel with less grip, so that the axle keeps its side force and the brakes do
not turn the car. A limit of the yaw moment: the wheel with more grip gets its pressure more slowly, so that the driver
has the time to steer against it. Both act only once the other wheel has been released in this braking, on its own
evidence. What the other does counts from 10 ms after its stamp on, so that it does not matter which is asked first.
"""

from collections import deque
from collections.abc import Mapping
from math import inf, isfinite
from typing import Final

from abs_supervisor.brake_model import BAND
from abs_supervisor.measurements import GAP
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import FRONT, REAR, Vehicle

NO_AXLE: Final = "none"
SELECT_LOW: Final = (NO_AXLE, FRONT, REAR)
"""Values of the parameter."""
_OLDER: Final = round(0.01 * NANOSECONDS)
_OLDEST: Final = round(GAP * NANOSECONDS)
"""[ns] an older pressure does not count: the other wheel is not heard of any more."""


class _Side:
    """Torques of one of the two, and its first release."""

    def __init__(self) -> None:
        self.torques: deque[tuple[int, float]] = deque()
        self.released_at: int | None = None


class Axle:
    """Holds for both wheels what the other does."""

    def __init__(self, wheels: tuple[str, str], select_low: bool, growth: float) -> None:
        """Choose the rule.

        Args:
            wheels: their names.
            select_low: whether a wheel with more pressure than the other is released.
            growth: of the difference of their brake torques that is allowed else, from the first release on [N m/s].
        """
        self._sides = {wheel: _Side() for wheel in wheels}
        self._other = dict(zip(wheels, reversed(wheels), strict=True))
        self._select_low, self._growth = select_low, growth

    def forget(self, wheel: str) -> None:
        """Forget a wheel."""
        self._sides[wheel] = _Side()

    def note(self, wheel: str, stamp: int, torque: float, command: Command, released: bool) -> None:
        """Take what a wheel does.

        Args:
            wheel: its name.
            stamp: [ns], later than its last.
            torque: of its brake [N m], NaN where unknown.
            command: that it got.
            released: whether it was released on its own evidence.
        """
        side = self._sides[wheel]
        if command is Command.NONE or not isfinite(torque):
            self.forget(wheel)
            return
        if released and side.released_at is None:
            side.released_at = stamp
        side.torques.append((stamp, torque))
        while len(side.torques) > 1 and side.torques[1][0] <= stamp - _OLDEST:
            side.torques.popleft()

    def most(self, wheel: str, stamp: int, torque: float, degraded: bool = False) -> Command:
        """Return the most that a wheel may get at a stamp [ns] with its present torque [N m].

        INCREASE is everything, HOLD no more than now, DECREASE less. `degraded`: the speed of the car comes from its
        wheels alone, and the axle is controlled select-low.
        """
        select_low = self._select_low or degraded
        other = self._sides[self._other[wheel]]
        if other.released_at is None:
            return Command.INCREASE
        lower = inf
        for at, known in other.torques:
            if at <= stamp - _OLDER:
                lower = known if at >= stamp - _OLDEST else inf
        growth = 0.0 if select_low else self._growth
        excess = torque - lower - growth * (stamp - other.released_at) / NANOSECONDS
        if select_low and excess > 2.0 * BAND:
            return Command.DECREASE
        return Command.HOLD if excess > BAND else Command.INCREASE


def axles(vehicle: Vehicle, select_low: str) -> Mapping[str, Axle]:
    """Return the axle of each wheel that has one of two wheels.

    Args:
        vehicle: its `front_yaw_moment_rate` > 0 limits the front axle.
        select_low: axle whose wheels get the same pressure, of SELECT_LOW.
    """
    found: dict[str, Axle] = {}
    for place in (FRONT, REAR):
        wheels = [wheel for wheel in vehicle.wheels if wheel.axle == place]
        if len(wheels) != 2:
            continue
        first, second = wheels
        # M = (F_left - F_right) track / 2, and F = T / r.
        rate = vehicle.front_yaw_moment_rate if place == FRONT else 0.0
        growth = 2.0 * first.radius * rate / vehicle.track if rate > 0.0 else inf
        found[first.name] = found[second.name] = Axle((first.name, second.name), select_low == place, growth)
    return found
