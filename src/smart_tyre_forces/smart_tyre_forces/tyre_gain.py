"""Gains of a tyre relative to its calibration."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from smart_tyre_forces.correction import Patch

Array = NDArray[np.float64]

_LOAD_RATE = 50.0
"""Angular frequency about which the road varies the load [rad/s]: the resonance of a body and a wheel on springs."""


@dataclass(frozen=True)
class TyreGain:
    """State of a tyre against its calibration."""

    length: float = 1.0
    """Length of the patch at the same load, over that of the calibration."""
    length_stddev: float = 0.0
    force: Array = field(default_factory=lambda: np.zeros(3))
    """g [-], o [N], d [N s/rad]."""
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    """Of `force`, shape (3, 3)."""
    scatter: float = 0.0
    """Variance of the shift by the changing load, over the square of the time in the patch [rad^2/s^2]."""

    def load_scatter(self, patch: Patch) -> tuple[float, float]:
        """Return the deviations of shift and length [rad] by a load that changes between the two fronts.

        The shift sees its rate of change, the length its curvature, smaller by half the time times the frequency.
        """
        if self.scatter == 0.0:
            return 0.0, 0.0
        time = patch.length_raw / patch.passage.wheel_speed
        shift = float(np.sqrt(self.scatter)) * time
        return shift, 0.5 * time * _LOAD_RATE * shift
