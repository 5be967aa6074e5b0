"""Static monotone maps between an angle of the contact patch and a force, (8.14) and (8.16).

The map is fitted as angle over force, because the angle carries the noise (and the unevenness of the road, which a
reference force does not include), and inverted for use.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_MARGIN = 0.3
"""Extrapolation allowed at either end, as a share of the calibrated range."""
_POINTS = 601


@dataclass(frozen=True)
class ForceMap:
    """angle = sum c_i force^i over a range of force."""

    coefficients: tuple[float, ...]
    """c_0, c_1, ... [rad / N^i]."""
    lowest: float
    """Smallest calibrated force [N]."""
    highest: float
    """Largest calibrated force [N]."""

    def __post_init__(self) -> None:
        """Refuse a map that cannot be inverted."""
        if not self.highest > self.lowest:
            raise ValueError(f"force map: empty range {self.lowest} to {self.highest} N")
        if not np.all(np.diff(self._table[1]) > 0.0):
            raise ValueError(
                f"force map: angle does not grow with force between {self.lowest:.0f} and {self.highest:.0f} N"
            )

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest force that it gives [N]."""
        margin = _MARGIN * (self.highest - self.lowest)
        return self.lowest - margin, self.highest + margin

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        force = np.linspace(*self.reach, _POINTS, dtype=np.float64)
        return force, self.angle(force)

    def angle(self, force: ArrayLike) -> Array:
        """Return the angle [rad] that belongs to a force [N]."""
        return np.asarray(np.polynomial.polynomial.polyval(np.asarray(force, dtype=np.float64), self.coefficients))

    def force(self, angle: float) -> float:
        """Return the force [N] that belongs to an angle [rad]; NaN outside the calibrated range and its margin."""
        force, table = self._table
        return float(np.interp(angle, table, force, left=np.nan, right=np.nan))

    def slope(self, force: float) -> float:
        """Return d force / d angle [N/rad] at a force [N]."""
        derivative = np.polynomial.polynomial.polyder(np.asarray(self.coefficients))
        return 1.0 / float(np.polynomial.polynomial.polyval(force, derivative))

    @classmethod
    def fit(cls, force: Array, angle: Array, powers: tuple[int, ...]) -> "ForceMap":
        """Fit angle [rad] over force [N], both of shape (n,), by least squares with the given powers of force.

        Raises:
            ValueError: the result is not monotone over the range of the data.
        """
        scale = float(np.max(np.abs(force)))
        design = np.stack([(force / scale) ** power for power in powers], axis=1)
        solution = np.linalg.lstsq(design, angle, rcond=None)[0]
        coefficients = np.zeros(max(powers) + 1)
        coefficients[list(powers)] = solution / scale ** np.asarray(powers)
        return cls(tuple(float(c) for c in coefficients), float(np.min(force)), float(np.max(force)))
