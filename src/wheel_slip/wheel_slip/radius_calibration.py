"""Effective rolling radii while the car coasts, against a speed sensor.

    r_i = sum(v omega_i) / sum(omega_i^2)

with v of the speed sensor. A sample counts while every wheel changes its speed slowly (no braking, no spin), rolls
faster than `minimum_speed` and is near the others (no curve). The standard deviation is that of the residual, of which
one every `_CORRELATION` counts as independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Final

from vehicle_models.nanoseconds import NANOSECONDS

_CORRELATION: Final = 0.2
"""Time over which residuals are correlated [s]."""
_LONGEST_STEP: Final = 0.3
"""Longer steps between samples [s] are gaps."""
_SPREAD: Final = 0.05
"""Share by which rim speeds may differ."""
_RATE_TIME: Final = 0.3
"""Time [s] over which the acceleration of the wheels is taken."""


@dataclass(frozen=True)
class CalibrationParameters:
    """Which samples count, and how many are needed."""

    max_acceleration: float = 2.0
    """Largest change of the rim speeds [m/s^2]: engine braking passes, braking does not."""
    minimum_speed: float = 5.0
    """[m/s]"""
    needed: float = 1.5
    """Coasting time [s] below which there is no result."""


@dataclass(frozen=True)
class Radii:
    """Result of a calibration."""

    radii: tuple[float, ...]
    """[m], in the order of the wheels."""
    stddevs: tuple[float, ...]
    """[m]"""
    seconds: float
    """Coasting time used [s]."""


class RadiusCalibration:
    """Accumulates coasting samples of one car."""

    def __init__(self, nominal: Sequence[float], parameters: CalibrationParameters) -> None:
        """Start with the nominal radii [m], which decide what counts as rolling."""
        self._nominal = tuple(nominal)
        self._p = parameters
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        count = len(self._nominal)
        self._cross, self._square = [0.0] * count, [0.0] * count
        self._reference_square = 0.0
        self._samples = 0
        self._seconds = 0.0
        self._last: int | None = None
        self._anchor: tuple[int, list[float]] | None = None
        self._calm = False

    def update(self, stamp: int, wheel_speeds: Sequence[float], speed: float) -> bool:
        """Take the wheel speeds [rad/s] at a stamp [ns] and the measured speed [m/s] there.

        Returns:
            Whether the sample counted.
        """
        if not all(map(isfinite, wheel_speeds)):
            return False
        rims = [omega * radius for omega, radius in zip(wheel_speeds, self._nominal, strict=True)]
        mean = sum(rims) / len(rims)
        dt = (stamp - self._last) / NANOSECONDS if self._last is not None else float("inf")
        self._last = stamp
        if not self._coasts(stamp, rims, mean, dt) or not isfinite(speed):
            return False
        for index, omega in enumerate(wheel_speeds):
            self._cross[index] += speed * omega
            self._square[index] += omega * omega
        self._reference_square += speed * speed
        self._samples += 1
        self._seconds += dt
        return True

    def result(self) -> Radii | str:
        """Return the radii so far, or the reason why there are none."""
        if self._seconds < self._p.needed:
            return f"{self._seconds:.1f} s of coasting, {self._p.needed:.1f} s needed"
        radii = tuple(cross / square for cross, square in zip(self._cross, self._square, strict=True))
        independent = max(self._seconds / _CORRELATION, 2.0)
        stddevs = tuple(
            sqrt(
                max(self._reference_square - radius * cross, 0.0)
                / self._samples
                / (square / self._samples)
                / independent
            )
            for radius, cross, square in zip(radii, self._cross, self._square, strict=True)
        )
        return Radii(radii, stddevs, self._seconds)

    def _coasts(self, stamp: int, rims: list[float], mean: float, dt: float) -> bool:
        if dt > _LONGEST_STEP or dt <= 0.0:
            self._anchor, self._calm = (stamp, rims), False
            return False
        if self._anchor is None:
            self._anchor = (stamp, rims)
        elapsed = (stamp - self._anchor[0]) / NANOSECONDS
        if elapsed >= _RATE_TIME:
            changes = [abs(now - before) / elapsed for now, before in zip(rims, self._anchor[1], strict=True)]
            self._calm = max(changes) <= self._p.max_acceleration
            self._anchor = (stamp, rims)
        near = max(rims) - min(rims) <= _SPREAD * abs(mean)
        return self._calm and near and mean >= self._p.minimum_speed
