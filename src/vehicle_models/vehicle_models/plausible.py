"""Limits of plausibility: values beyond them are garbage, not measurements of a car on a road. Every node uses them."""

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
NEW_RUN: Final = 50_000_000
"""A stamp that goes back by this or more [ns] begins a new run (a looped bag, a reset plant); less: a late sample."""


def is_vague(speed: float, variance: float) -> bool:
    """Whether a speed of the car [m/s] with a variance [m^2/s^2] says nothing, nor any slip by it.

    Its deviation is above a third of it, and of 4.5 m/s: a slip is then not linear in its error any more, and a wheel
    that rolls in a car that has become slow unseen has a slip of 0.9 with a small deviation.
    """
    largest = max(abs(speed), 4.5) / 3.0
    return variance > largest * largest
