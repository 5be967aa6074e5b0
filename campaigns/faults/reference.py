"""The stop without ABS: the plant alone, which no command reaches."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

from campaigns.faults.manoeuvre import ONSET, Manoeuvre
from corner_sim.plant import SAMPLE_TIME, PlantSample

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
    torque: float
    """Of the wheel that is braked least [N m]."""


@lru_cache(maxsize=1)  # a gentle stop on snow has 30,000 samples
def samples_without_abs(manoeuvre: Manoeuvre) -> Sequence[PlantSample]:
    """Brake without commands. Without them no sensor reaches the plant, so it is the same for every seed and fault."""
    simulation = manoeuvre.simulation(0)
    samples = [simulation.sample]
    while simulation.end is None and simulation.time < _LONGEST:
        simulation.advance()
        samples.append(simulation.sample)
    return samples


@cache
def without_abs(manoeuvre: Manoeuvre) -> Reference:
    """Return the numbers of the stop without ABS."""
    samples = samples_without_abs(manoeuvre)
    return Reference(
        duration=samples[-1].index * SAMPLE_TIME - ONSET,
        distance=samples[-1].distance - samples[round(ONSET / SAMPLE_TIME)].distance,
        locks=any(each.speed > ABS_END and each.slip.max() > LOCK_SLIP for each in samples),
        torque=float(samples[-1].brake_torque.min()),
    )
