"""A fault of the campaign, when it acts, and what is asked of the graph under it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import inf

from campaigns.faults.fault import Fault, Site


class Hit(Enum):
    """Whose ABS the fault may cost."""

    NO_WHEEL = "no wheel"
    FIRST_WHEEL = "the first wheel"
    ALL_WHEELS = "all wheels"


BEFORE_BRAKING = -0.25
"""Begin of a fault that is there before the brake [s since the onset]."""
IN_BRAKING = 0.5
"""Begin of a fault that comes while the car brakes [s since the onset]."""


@dataclass(frozen=True)
class Case:
    """A fault from `begin` to `end` [s since the onset of braking]."""

    name: str
    make: Callable[[Site], Fault]
    hit: Hit = Hit.NO_WHEEL
    begin: float = IN_BRAKING
    end: float = inf
    none_within: float = inf
    """[s] from the last good message to NONE at every wheel that is hit."""
    none_later: float = 0.0
    """[s] more for that at a demand above the peak torque, where the ABS must first see what a release does."""
    named_within: float = inf
    """[s] from the begin, or from the onset where that is later, to a reason or diagnostics above OK."""
    named: str = ""
    """What the text must contain in which the fault is named."""
    stretch: float = inf
    """Longest distance over that of the same stop without fault."""
