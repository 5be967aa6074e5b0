"""Physical bounds of a car on a road, the same for every estimator.

Beyond the bounds of a message's values (HIGHEST_WHEEL_SPEED to LATEST_STAMP) a value is garbage and no measurement. The
bounds of the road and of braking are narrower: they decide between explanations of values that are possible.
"""

from math import nan
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

HIGHEST_WHEEL_SPEED: Final = 1000.0
"""Highest speed of a wheel [rad/s]."""
HIGHEST_SPEED: Final = 200.0
"""Highest speed of a car [m/s]."""
HIGHEST_ACCELERATION: Final = 200.0
"""Highest acceleration of a car, measured on a body that is shaken by kerbs [m/s^2]."""
HIGHEST_TORQUE: Final = 1e5
"""Highest torque of a brake [N m]."""
HIGHEST_PRESSURE: Final = 1e8
"""Highest pressure of a brake line [Pa], some five times that of an emergency stop."""
HIGHEST_MU: Final = 2.5
"""Highest friction coefficient [-]: a racing tyre on a track that is rubbered in has 1.8."""
HIGHEST_SLIP: Final = 1.5
"""Highest slip of a wheel [-], either sign: beyond it the speed of the car is wrong, or nothing holds the wheel."""
HIGHEST_SLIP_RATE: Final = 1e4
"""Highest slip rate [1/s]: a wheel that is thrown from rolling to locked within a sample."""
LATEST_STAMP: Final = (2**31 - 2) * NANOSECONDS
"""Latest plausible stamp [ns]. A message stamp can hold one second more."""
HIGHEST_ROAD_FRICTION: Final = 1.5
"""Highest friction coefficient of a tyre on a public road [-]."""
ICE_FRICTION: Final = 0.05
"""Friction coefficient of wet ice, the smoothest road [-]."""
LOWEST_APPARENT_FRICTION: Final = 0.035
"""The same as it appears by a nominal brake gain and load, both of which may be wrong [-]."""
STANDING: Final = 0.6
"""Speed of the rim [m/s] below which an encoder reads zero."""
HARDEST_BRAKING: Final = 12.0
"""Highest deceleration of any car on any road [m/s^2]."""
NEW_RUN: Final = 50_000_000
"""A stamp that goes back by this or more [ns] begins a new run (a looped bag, a reset plant); less: a late sample."""


def is_vague(speed: float, stddev: float) -> bool:
    """Return True where a vehicle speed [m/s] is too uncertain for a slip: its stddev exceeds a third of it or 1.5 m/s.

    The slip is then no longer linear in the error of the speed, and a wheel that rolls in a car that has slowed down
    unnoticed has a slip of 0.9 with a small standard deviation.
    """
    return stddev > max(abs(speed), 4.5) / 3.0


class SlowestCar:
    """Least speed of a car by the wheel speeds it had: one with locked wheels is not at rest.

    It follows the fastest wheel upwards at once, and downwards no faster than a car can brake.
    """

    def __init__(self, hardest_braking: float = HARDEST_BRAKING) -> None:
        """Start without a speed; `hardest_braking` is that of the car [m/s^2], > 0."""
        self._hardest_braking = hardest_braking
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._last: int | None = None
        self.speed = nan
        """[m/s], NaN before the first sample, then >= 0."""

    def update(self, stamp: int, rim: float) -> float:
        """Take the circumferential speed [m/s] of the fastest wheel at a stamp [ns]; return `speed`."""
        slowest = 0.0
        if self._last is not None:
            slowest = max(self.speed - self._hardest_braking * (stamp - self._last) / NANOSECONDS, 0.0)
        self._last, self.speed = stamp, max(rim, slowest)
        return self.speed
