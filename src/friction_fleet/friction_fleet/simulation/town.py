"""Roads of a small town, with friction that is known at every place and hour of a day."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, radians
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from friction_fleet.cells import cell_of

Array = NDArray[np.float64]
Node = tuple[int, int]
Street = tuple[Node, Node]

START = 1_768_435_200
"""Midnight at which the day begins [s since 1970]: 2026-01-15 UTC."""
HOURS = 24.0
ORIGIN = 48.1, 11.5
"""Latitude and longitude of the south-western corner [deg]."""
BLOCK = 400.0
"""Length of a street [m]."""
_NODES = 3
METRES_PER_DEGREE = 111_195.0
_POINTS = 2.0
"""Distance of the points at which the truth is taken [m]."""
DRY = 0.95, 1.15
"""Friction of the dry streets, from and to."""
_WET, _SNOW, _ICE = 0.70, 0.25, 0.12
"""Wet over dry; friction of snow and ice."""
RAIN = 6.0, 8.0
"""Hours between which it rains; each street dries 1 to 4 h after."""
_FROST = 18.0


@dataclass(frozen=True)
class Patch:
    """A slippery part of a street."""

    street: Street
    begin: float
    end: float
    """[m] along the street"""
    from_hour: float
    to_hour: float
    surface: str
    """snow or ice"""


PATCHES = (
    Patch(((0, 2), (1, 2)), 60.0, 340.0, 0.0, HOURS, "snow"),
    Patch(((2, 0), (2, 1)), 100.0, 300.0, 0.0, 14.0, "snow"),
    Patch(((1, 0), (1, 1)), 150.0, 260.0, 0.0, 10.0, "ice"),
    Patch(((1, 0), (1, 1)), 150.0, 260.0, 20.0, HOURS, "ice"),
    Patch(((0, 1), (1, 1)), 240.0, 340.0, 0.0, 9.0, "ice"),
    Patch(((1, 2), (2, 2)), 100.0, 320.0, _FROST, HOURS, "ice"),
)
"""A snow patch that stays, one that melts, two icy bridges in the morning, one at night, a street that freezes over."""


class Town:
    """Three by three crossings, and the streets between them."""

    def __init__(self, seed: int) -> None:
        """Draw the dry friction of each street, and when it dries."""
        rng = np.random.default_rng([seed, 21])
        span = range(_NODES)
        across = [((x, y), (x + 1, y)) for x in span[:-1] for y in span]
        along = [((x, y), (x, y + 1)) for x in span for y in span[:-1]]
        self.streets: tuple[Street, ...] = (*across, *along)
        self._dry = {street: float(rng.uniform(*DRY)) for street in self.streets}
        self._dries = {street: RAIN[1] + float(rng.uniform(1.0, 4.0)) for street in self.streets}

    def road(self, street: Street, offset: float, hour: float) -> tuple[str, float]:
        """Return surface and friction of a place, `offset` [m] along its street."""
        for patch in PATCHES:
            if patch.street == street and patch.begin <= offset < patch.end and patch.from_hour <= hour < patch.to_hour:
                return patch.surface, _ICE if patch.surface == "ice" else _SNOW
        dry = self._dry[street]
        return ("wet", _WET * dry) if RAIN[0] <= hour < self._dries[street] else ("dry", dry)

    def changes(self) -> list[float]:
        """Return the hours at which the friction of any place changes, from 0 to HOURS."""
        of_patches = [hour for patch in PATCHES for hour in (patch.from_hour, patch.to_hour)]
        return sorted({0.0, HOURS, RAIN[0], *self._dries.values(), *of_patches})

    def route(self, rng: np.random.Generator, length: float) -> list[tuple[Street, bool]]:
        """Draw a way without turning back, at least `length` [m]: streets, and whether each is driven forwards."""
        before: Street | None = None
        here: Node = (int(rng.integers(_NODES)), int(rng.integers(_NODES)))
        way: list[tuple[Street, bool]] = []
        while len(way) * BLOCK < length:
            choices = [street for street in self.streets if here in street and street != before]
            before = choices[int(rng.integers(len(choices)))]
            way.append((before, here == before[0]))
            here = before[1] if here == before[0] else before[0]
        return way

    def write_truth(self, path: Path) -> None:
        """Write the friction of every cell over the day as CSV."""
        points = [(street, (k + 0.5) * _POINTS) for street in self.streets for k in range(round(BLOCK / _POINTS))]
        cells = [cell_of(*place(street, offset)) for street, offset in points]
        changes = self.changes()
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["cell", "begin", "end", "mu_lowest", "mu_mean", "mu_highest", "points"])
            for begin, end in pairwise(changes):
                of_cells: dict[int, list[float]] = {}
                for (street, offset), cell in zip(points, cells, strict=True):
                    of_cells.setdefault(cell, []).append(self.road(street, offset, begin)[1])
                for cell, mu in sorted(of_cells.items()):
                    levels = (min(mu), sum(mu) / len(mu), max(mu))
                    times = (START + 3600.0 * begin, START + 3600.0 * end)
                    writer.writerow([cell, *times, *(f"{level:.4f}" for level in levels), len(mu)])


def place(street: Street, offset: float) -> tuple[float, float]:
    """Return latitude and longitude [deg] of a place, `offset` [m] along a street."""
    (x0, y0), (x1, y1) = street
    east, north = ((a * BLOCK + offset * (b - a)) for a, b in ((x0, x1), (y0, y1)))
    latitude = ORIGIN[0] + north / METRES_PER_DEGREE
    return latitude, ORIGIN[1] + east / (METRES_PER_DEGREE * cos(radians(ORIGIN[0])))


def along(way: Sequence[tuple[Street, bool]], distance: float) -> tuple[Street, float]:
    """Return the street at a distance [m] from the start of a way, and the place along it [m]."""
    number, offset = divmod(distance, BLOCK)
    street, forwards = way[int(number)]
    return street, offset if forwards else BLOCK - offset
