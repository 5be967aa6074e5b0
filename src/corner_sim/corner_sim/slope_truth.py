"""True crossings of the friction curve's peak."""

import numpy as np
from numpy.typing import NDArray

from corner_sim.plant import SAMPLE_TIME_NS, PlantSample


class SlopeCrossings:
    """Counts, per wheel, how often the sign of the slope mu_1 changed, and where."""

    def __init__(self, count: int) -> None:
        """Start with no crossing on `count` wheels."""
        self.count: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """Crossings so far."""
        self.sign: NDArray[np.int64] = np.ones(count, dtype=np.int64)
        """Sign of the slope at the last sample."""
        self.slip: NDArray[np.float64] = np.full(count, np.nan)
        """Slip at the last crossing [-]: lambda_max of the road; NaN before."""
        self.stamp: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """Stamp of the last crossing [ns]; 0 before."""
        self.surface_changes: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        """How often the surface changed."""
        self.surface_changed: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        """Whether the surface changed at the last sample."""
        self._previous: PlantSample | None = None

    def update(self, sample: PlantSample, stamp_ns: int) -> None:
        """Take the next sample, with its stamp [ns].

        The time of a crossing is interpolated between the samples. Where the curve itself changed under the wheel, the
        crossing is at the sample and at its slip.
        """
        before, self._previous = self._previous, sample
        sign = np.where(sample.slope < 0.0, -1, 1)
        if before is not None:
            self.surface_changed = sample.surface != before.surface
            self.surface_changes = self.surface_changes + self.surface_changed
            for i in np.flatnonzero(sign != self.sign):
                self.count[i] += 1
                self.slip[i], self.stamp[i] = sample.tyre_slip[i], stamp_ns
                if not self.surface_changed[i]:
                    peak = float(sample.peak[i, 0])
                    remaining = (sample.tyre_slip[i] - peak) / (sample.tyre_slip[i] - before.tyre_slip[i])
                    self.slip[i] = peak
                    self.stamp[i] = stamp_ns - round(remaining * SAMPLE_TIME_NS)
        self.sign = sign
