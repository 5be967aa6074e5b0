"""The stop without ABS: the plant alone, which no command reaches."""

from dataclasses import dataclass
from functools import cache

from friction_evaluation.faults.manoeuvre import ONSET, Manoeuvre

_LONGEST = 600.0
"""[s]"""
_LOCK_SLIP, _FAST = 0.95, 5.0
"""[-], [m/s]"""


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
        locks = locks or (simulation.speed > _FAST and simulation.largest_slip > _LOCK_SLIP)
    return Reference(simulation.time - ONSET, simulation.distance - begin, locks)
