"""Released wheel check: an unbraked wheel that does not spin up already rolls, and its slip is wrong."""

from math import nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HARDEST_BRAKING, ICE_FRICTION
from vehicle_models.vehicle import CornerParameters

_OPEN: Final = 0.02
"""Friction whose torque an open brake stays below: the noise of its sensor, its drag."""
_TIME: Final = round(0.05 * NANOSECONDS)
"""[ns] over which the wheel has to gain speed."""
_DIVES: Final = 0.5
"""[m/s] A wheel that is so much slower than the hardest braking from then on would make it, slips."""


class ReleasedWheel:
    """Compares the slip of one wheel with how it moves while its brake is open."""

    def __init__(self) -> None:
        """Start with a brake that is not known to be open."""
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._since: int | None = None
        self._begun = nan
        self.rolls = False
        """Whether the wheel rolls although its slip is large; until the slip is small, or the wheel dives."""

    def update(
        self, stamp: int, corner: CornerParameters, wheel_speed: float, torque: float, slip: float, held: float
    ) -> None:
        """Take a sample.

        Args:
            stamp: [ns], later than the last.
            corner: the wheel.
            wheel_speed: [rad/s].
            torque: of the brake [N m].
            slip: [-].
            held: slip that the law holds [-]; a smaller one contradicts nothing.
        """
        road = corner.radius * corner.vertical_load
        since, gained = self._since, wheel_speed - self._begun
        if slip <= held:
            self.reset()
        elif self.rolls:
            slowed = 0.0 if since is None else HARDEST_BRAKING * (stamp - since) / NANOSECONDS + _DIVES
            if corner.radius * gained < -slowed:
                self.reset()
        elif not torque < _OPEN * road:
            self._since = None
        elif since is None:
            self._since, self._begun = stamp, wheel_speed
        elif stamp - since >= _TIME:
            expected = ICE_FRICTION * road / corner.inertia * (stamp - since) / NANOSECONDS
            self.rolls = gained < expected
            self._since, self._begun = stamp, wheel_speed
