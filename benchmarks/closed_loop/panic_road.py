"""The roads of a panic stop: one surface, or one that changes soon after the onset."""

from typing import Final

from corner_sim.road import Road

CHANGES: Final = (
    "dry to snow",
    "snow to dry",
    "dry to wet",
    "wet to dry",
    "dry to cobblestone",
    "cobblestone to dry",
)
"""Names of the roads that change."""
_CHANGE_AT: Final = 30.0
"""[m] from the onset: the peak of the first surface has been passed, and the car is still fast."""
_TO: Final = " to "


def panic_road(name: str) -> Road:
    """Return the road of a name: that of a surface, or of two with ` to ` between. Distances are from the onset."""
    names = tuple(name.split(_TO))
    return Road(names, tuple(_CHANGE_AT * place for place in range(len(names))))
