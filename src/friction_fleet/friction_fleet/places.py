"""Places along a drive, by the fixes of a satellite receiver in its bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_fleet.cells import cells_of
from friction_runtime.installed import message_class
from friction_runtime.messages import to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS

_TYPE = "sensor_msgs/msg/NavSatFix"
_NO_FIX = -1
"""Status; receivers that set none leave it unknown."""
_LONGEST_GAP = 3.0
"""Time between fixes over which a place is interpolated [s]."""
NOWHERE = 0
"""Cell of what has no place."""


class Places:
    """Place by stamp; none where fixes are missing."""

    def __init__(
        self, stamps: NDArray[np.int64], latitudes: NDArray[np.float64], longitudes: NDArray[np.float64]
    ) -> None:
        """Take the fixes, (N,): stamps [ns], latitudes and longitudes [deg]."""
        order = np.argsort(stamps, kind="stable")
        self._stamps = stamps[order]
        self._latitudes, self._longitudes = latitudes[order], longitudes[order]

    def at(self, stamps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return latitudes and longitudes [deg] at some stamps [ns], (2, M); NaN where no place is known."""
        if self._stamps.size < 2:
            return np.full((2, stamps.size), np.nan)
        after = np.clip(np.searchsorted(self._stamps, stamps), 1, self._stamps.size - 1)
        gap = self._stamps[after] - self._stamps[after - 1]
        share = (stamps - self._stamps[after - 1]) / np.maximum(gap, 1)
        known = (share >= 0.0) & (share <= 1.0) & (gap <= _LONGEST_GAP * NANOSECONDS)
        between = [
            each[after - 1] + share * (each[after] - each[after - 1]) for each in (self._latitudes, self._longitudes)
        ]
        return np.where(known, np.array(between), np.nan)

    def cells(self, stamps: NDArray[np.int64]) -> NDArray[np.uint64]:
        """Return the cells at some stamps [ns], (M,); NOWHERE where no place is known."""
        latitudes, longitudes = self.at(stamps)
        found = np.full(stamps.size, NOWHERE, dtype=np.uint64)
        known = np.isfinite(latitudes)
        found[known] = cells_of(latitudes[known], longitudes[known])
        return found


def read_places(bag: Path) -> Places:
    """Read the fixes of a bag: of the topic that has most of them.

    Raises:
        BagError: the bag cannot be read.
    """
    rows: list[tuple[int, float, float]] = []
    with BagReader(bag) as reader:
        of_type = {topic: number for topic, number in reader.counts.items() if topic.type == _TYPE and number}
        if of_type:
            topic = max(of_type, key=lambda each: (of_type[each], each.name))
            kind = message_class(_TYPE)
            for _, _, data in reader.messages([topic]):
                try:
                    fix = decode(data, kind)
                except ValueError:
                    continue
                if fix.status.status != _NO_FIX and np.isfinite(fix.latitude + fix.longitude):
                    rows.append((to_nanoseconds(fix.header.stamp), fix.latitude, fix.longitude))
    table = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 2)
    return Places(np.array([row[0] for row in rows], dtype=np.int64), table[:, 0], table[:, 1])
