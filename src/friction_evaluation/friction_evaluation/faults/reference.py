"""The stop without ABS: the plant alone, which no command reaches."""

from dataclasses import dataclass
from functools import cache

from friction_evaluation.faults.manoeuvre import ONSET, Manoeuvre

_LONGEST = 600.0
"""[s]"""
ABS_END = 5.0
"""Utilisation and locks count above this speed [m/s], as in the part abs."""
LOCK_SLIP = 0.95


@dataclass(frozen=True)
class Reference:
    """From the onset of braking to standstill."""

    duration: float
    """[s]"""
    distance: float
    """[m]"""
    locks: bool
    """A wheel locks above 5 m/s: the demand is above its own peak torque, as at the rear at 0.9 of the front's."""


@cache
def without_abs(manoeuvre: Manoeuvre) -> Reference:
    """Brake without commands. Without them no sensor reaches the plant, so it is the same for every seed and fault."""
    simulation = manoeuvre.simulation(0)
    begin, locks = 0.0, False
    while simulation.end is None and simulation.time < _LONGEST:
        simulation.advance()
        if simulation.time <= ONSET:
            begin = simulation.distance
        locks = locks or (simulation.speed > ABS_END and simulation.largest_slip > LOCK_SLIP)
    return Reference(simulation.time - ONSET, simulation.distance - begin, locks)
