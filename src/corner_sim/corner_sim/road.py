"""The road under the vehicle: surfaces of Table 8.1 one behind the other."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models import surfaces


@dataclass(frozen=True)
class Road:
    """Surfaces by the distance [m] at which each begins."""

    names: tuple[str, ...]
    distances: tuple[float, ...]

    def __init__(self, names: Sequence[str], distances: Sequence[float]) -> None:
        """Lay the road.

        Args:
            names: surfaces, at least one, each of vehicle_models.surfaces.SURFACES.
            distances: where each begins [m], same length, the first 0, strictly increasing.

        Raises:
            ValueError: a name is unknown, or the distances do not fit.
        """
        if not names or len(names) != len(distances):
            raise ValueError(
                f"surfaces and surface_distances must be of one length >= 1, are {len(names)} and {len(distances)}"
            )
        if distances[0] != 0.0 or not all(a < b for a, b in pairwise(distances)):
            raise ValueError(f"surface_distances must begin with 0 and increase, is {list(distances)}")
        object.__setattr__(self, "names", tuple(names))
        object.__setattr__(self, "distances", tuple(float(distance) for distance in distances))
        object.__setattr__(self, "_thetas", np.array([surfaces.surface(name) for name in names]))

    def index(self, distance: ArrayLike) -> NDArray[np.int64]:
        """Index of the surface at `distance` [m], same shape; a boundary belongs to the surface that begins there."""
        return np.maximum(np.searchsorted(np.array(self.distances), np.asarray(distance), side="right") - 1, 0)

    def theta(self, distance: ArrayLike) -> NDArray[np.float64]:
        """Burckhardt parameters at `distance` [m], shape (..., 3)."""
        thetas: NDArray[np.float64] = self._thetas  # type: ignore[attr-defined]
        return thetas[self.index(distance)]
