"""Places along a drive, by the fixes of a satellite receiver."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle_models.nanoseconds import NANOSECONDS

FIXES: Final = "sensor_msgs/msg/NavSatFix"
"""Type of the messages."""
_NO_FIX = -1
"""Status of one; receivers that set none leave it unknown."""
_LONGEST_GAP = 3.0
"""Time between fixes over which a place is interpolated [s]."""
_EARTH = 6.371e6
"""Radius [m]."""


class Places:
    """Place by stamp; none where fixes are missing."""

    def __init__(
        self, stamps: NDArray[np.int64], latitudes: NDArray[np.float64], longitudes: NDArray[np.float64]
    ) -> None:
        """Take places that are known, (N,): stamps [ns], latitudes and longitudes [deg]."""
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

    def metres(self, stamps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return how far east and north of the first fix the car was at some stamps [ns], (2, M) [m]."""
        if not self._stamps.size:
            return np.full((2, stamps.size), np.nan)
        latitudes, longitudes = self.at(stamps)
        begin = self._latitudes[0], self._longitudes[0]
        north, east = np.radians(latitudes - begin[0]), np.radians(longitudes - begin[1])
        return _EARTH * np.array([np.cos(np.radians(begin[0])) * east, north])


def places_of(
    stamps: NDArray[np.int64],
    latitudes: NDArray[np.float64],
    longitudes: NDArray[np.float64],
    statuses: NDArray[np.float64],
) -> Places:
    """Return the places of messages, (N,) each, of which some may have no fix."""
    good = (statuses != _NO_FIX) & np.isfinite(latitudes + longitudes)
    return Places(stamps[good], latitudes[good], longitudes[good])
