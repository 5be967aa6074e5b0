"""Radii learned while driving, and used once they are certain."""

from collections.abc import Sequence
from typing import Final

from friction_runtime.filters import SlidingWindow
from vehicle_models.nanoseconds import NANOSECONDS
from wheel_slip.radius_calibration import CalibrationParameters, Radii, RadiusCalibration
from wheel_slip.speed_sample import SpeedSample

_CERTAIN: Final = 0.001
"""Standard deviation, as a share of the radius, below which a learned radius is used."""
_NEEDED: Final = 20.0
"""Coasting time [s] after which learned radii may be used."""
_MEMORY: Final = round(0.6 * NANOSECONDS)
"""How long wheel speeds are kept for late samples of the speed sensor [ns]."""
_NEAR: Final = round(0.02 * NANOSECONDS)
"""Largest distance of wheel speeds from the time of a speed sample [ns]."""


class OnlineRadii:
    """Learns radii against the speed sensor."""

    def __init__(self, nominal: tuple[float, ...]) -> None:
        """Start with the nominal radii [m]."""
        self._calibration = RadiusCalibration(nominal, CalibrationParameters(needed=_NEEDED))
        self._radii: Radii | None = None
        self._recent: SlidingWindow[Sequence[float]] = SlidingWindow(_MEMORY)

    def update(self, stamp: int, wheel_speeds: Sequence[float], measured: Sequence[SpeedSample]) -> Radii | None:
        """Take a sample as SlipEstimator.update does; return the radii to use, None until they are certain."""
        counted = False
        self._recent.append(stamp, wheel_speeds)
        for sample in measured:
            when, speeds = min(self._recent, key=lambda known: abs(known[0] - sample.stamp))
            if abs(when - sample.stamp) <= _NEAR:
                counted |= self._calibration.update(sample.stamp, speeds, sample.speed)
        if counted:
            found = self._calibration.result()
            if (
                isinstance(found, Radii)
                and max(s / r for s, r in zip(found.stddevs, found.radii, strict=True)) < _CERTAIN
            ):
                self._radii = found
        return self._radii
