"""Cells of a map along a drive, and the places in its bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_bags.results.places import FIXES, Places, places_of
from friction_fleet.cells import cells_of
from friction_runtime.installed import message_class
from friction_runtime.messages import to_nanoseconds

NOWHERE = 0
"""Cell of what has no place."""


def cells_at(places: Places, stamps: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return the cells at some stamps [ns], (M,); NOWHERE where no place is known."""
    latitudes, longitudes = places.at(stamps)
    found = np.full(stamps.size, NOWHERE, dtype=np.uint64)
    known = np.isfinite(latitudes)
    found[known] = cells_of(latitudes[known], longitudes[known])
    return found


def read_places(bag: Path) -> Places:
    """Read the fixes of a bag: of the topic that has most of them.

    Raises:
        BagError: the bag cannot be read.
    """
    stamps: list[int] = []
    fixes: list[tuple[float, float, float]] = []
    with BagReader(bag) as reader:
        of_type = {topic: number for topic, number in reader.counts.items() if topic.type == FIXES and number}
        if of_type:
            topic = max(of_type, key=lambda each: (of_type[each], each.name))
            kind = message_class(FIXES)
            for _, _, data in reader.messages([topic]):
                try:
                    fix = decode(data, kind)
                except ValueError:
                    continue
                stamps.append(to_nanoseconds(fix.header.stamp))
                fixes.append((fix.latitude, fix.longitude, fix.status.status))
    return places_of(np.array(stamps, dtype=np.int64), *np.array(fixes, dtype=np.float64).reshape(-1, 3).T)
