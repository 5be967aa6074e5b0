"""Prior of a road's friction, before anything is felt: shares of kinds of roads, on a grid."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_parameters.parameter import parameter

Array = NDArray[np.float64]

GRID: Array = np.exp(np.linspace(np.log(0.03), np.log(1.8), 90))
"""Friction of a road, (90,)."""
_KINDS = ((1.17, 0.18), (0.81, 0.18), (0.22, 0.28), (0.055, 0.35))
"""Friction of dry and wet roads, of snow and ice: mean, and relative deviation, of tyres and roads of a kind."""
_FLOOR = 0.02
"""Share of roads of no kind, evenly over the grid."""


@dataclass(frozen=True)
class RoadPrior:
    """Shares of the roads that a car drives on; they need not sum up to one. A winter has others than a summer."""

    dry: float = parameter(0.55, "share of dry roads, friction 1.0 to 1.4", minimum=0.0, maximum=1.0)
    wet: float = parameter(0.25, "share of wet roads, friction 0.65 to 1.0", minimum=0.0, maximum=1.0)
    snow: float = parameter(0.15, "share of roads with snow, friction 0.15 to 0.35", minimum=0.0, maximum=1.0)
    ice: float = parameter(0.05, "share of roads with ice, friction 0.03 to 0.1", minimum=0.0, maximum=1.0)

    def __post_init__(self) -> None:
        """Refuse a prior of no road."""
        if not self.dry + self.wet + self.snow + self.ice > 0.0:
            raise ValueError("the shares of all roads are 0")

    def density(self) -> Array:
        """Return the probability of each friction of GRID, (90,)."""
        found = np.zeros_like(GRID)
        for share, (mean, spread) in zip((self.dry, self.wet, self.snow, self.ice), _KINDS, strict=True):
            bell = np.exp(-0.5 * (np.log(GRID / mean) / spread) ** 2)
            found += share * bell / bell.sum()
        found /= found.sum()
        return np.asarray((1.0 - _FLOOR) * found + _FLOOR / GRID.size)
