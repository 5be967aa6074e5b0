"""The stop without ABS: the plant alone, which no command reaches."""

from dataclasses import dataclass
from functools import cache

from friction_evaluation.faults.manoeuvre import ONSET, Manoeuvre

_LONGEST = 600.0
"""[s]"""


@dataclass(frozen=True)
class Reference:
    """From the onset of braking to standstill."""

    duration: float
    """[s]"""
    distance: float
    """[m]"""


@cache
def without_abs(manoeuvre: Manoeuvre) -> Reference:
    """Brake without commands. Without them no sensor reaches the plant, so it is the same for every seed and fault."""
    simulation = manoeuvre.simulation(0)
    begin = 0.0
    while simulation.end is None and simulation.time < _LONGEST:
        simulation.advance()
        if simulation.time <= ONSET:
            begin = simulation.distance
    return Reference(simulation.time - ONSET, simulation.distance - begin)
