"""Cells of the earth's surface by H3: hexagons, about 50 m across."""

from typing import Any

import h3.api.numpy_int as h3
import numpy as np
from numpy.typing import NDArray

RESOLUTION = 11
"""Of H3: hexagons with sides of 29 m, narrower than the distance of a stop."""
_REGION = 6
"""Of H3: hexagons with sides of 3.7 km, each of one weather."""
SPACING = 50.0
"""Distance of the centres of neighbours [m]."""


def cell_of(latitude: float, longitude: float) -> int:
    """Return the cell of a place [deg]."""
    return int(h3.latlng_to_cell(latitude, longitude, RESOLUTION))


def cells_of(latitudes: NDArray[np.float64], longitudes: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Return the cells of places [deg], (N,)."""
    pairs = zip(latitudes.tolist(), longitudes.tolist(), strict=True)
    return np.array([cell_of(*pair) for pair in pairs], dtype=np.uint64)


def region_of(cell: int) -> int:
    """Return the region of one weather that a cell lies in."""
    return int(h3.cell_to_parent(cell, _REGION))


def centre(cell: int) -> tuple[float, float]:
    """Return latitude and longitude [deg] of the centre of a cell."""
    latitude, longitude = h3.cell_to_latlng(cell)
    return float(latitude), float(longitude)


def outline(cell: int) -> list[tuple[float, float]]:
    """Return longitude and latitude [deg] of each corner of a cell, in the order of GeoJSON."""
    return [(float(longitude), float(latitude)) for latitude, longitude in h3.cell_to_boundary(cell)]


def outlines(cells: list[int]) -> Any:
    """Return the geometry of touching cells as GeoJSON has it, without the borders between them."""
    return h3.cells_to_geo(cells)


def neighbours(cell: int) -> list[int]:
    """Return the cells around a cell."""
    return sorted(int(each) for each in h3.grid_ring(cell, 1))
