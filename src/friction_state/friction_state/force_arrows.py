"""Forces of the tyres as arrows at their contact patches, coloured by the share of the grip that they use.

The frame is that of the car: x forward, y left, z up, its origin on the road below the centre of gravity.
"""

from dataclasses import dataclass
from math import isfinite

from vehicle_models.vehicle import FRONT, Vehicle, Wheel

Point = tuple[float, float, float]
Colour = tuple[float, float, float]

METRES_PER_NEWTON = 1.0 / 4000.0
"""Length of an arrow over its force: some metre for the load of a car's wheel."""
UNUSED: Colour = (0.34, 0.65, 0.86)
USED: Colour = (0.78, 0.31, 0.04)
"""Colours of a tyre that uses no grip and of one that uses all of it; both are seen by colour-blind people."""
UNKNOWN: Colour = (0.6, 0.6, 0.6)
"""Colour where the grip is not known."""


@dataclass(frozen=True)
class Arrow:
    """A force."""

    tail: Point
    """[m]"""
    tip: Point
    """[m]"""


def contact_patch(vehicle: Vehicle, wheel: Wheel) -> Point:
    """Return the place of a wheel on the road [m]."""
    ahead = (1.0 - vehicle.front_load_share) if wheel.axle == FRONT else -vehicle.front_load_share
    return ahead * vehicle.wheelbase, (0.5 if wheel.side == "left" else -0.5) * vehicle.track, 0.0


def force_arrows(place: Point, fx: float, fz: float) -> tuple[Arrow, Arrow]:
    """Return the arrows of Fx along the road and of Fz [N], which pushes the tyre up, at a contact patch [m]."""
    x, y, z = place
    return (
        Arrow(place, (x + METRES_PER_NEWTON * fx, y, z)),
        Arrow(place, (x, y, z + METRES_PER_NEWTON * fz)),
    )


def grip_colour(fx: float, fz: float, mu_max: float) -> Colour:
    """Return the colour of a tyre by |Fx| over what the road gives at its load; `mu_max` is NaN where not known [-]."""
    if not (isfinite(mu_max) and mu_max > 0.0 and fz > 0.0):
        return UNKNOWN
    used = min(abs(fx) / (mu_max * fz), 1.0)
    red, green, blue = (cold + used * (hot - cold) for cold, hot in zip(UNUSED, USED, strict=True))
    return red, green, blue
