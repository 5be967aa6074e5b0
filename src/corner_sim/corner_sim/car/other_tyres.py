"""Tyres of neither Burckhardt's formula nor Pacejka's: brush model, load sensitivity, axle differences."""

from dataclasses import dataclass
from math import exp

import numpy as np

from corner_sim.car.tyre import Tyre

_FINEST = 1e-5
"""Step of slip with which a peak is looked for."""


@dataclass(frozen=True)
class Brush:
    """Brush model with a parabolic pressure, whose friction falls from rest to sliding with the slip.

    mu = m (3 x - 3 x^2 + x^3),    x = min(stiffness s / (3 m), 1),    m = sliding + (rest - sliding) exp(-s / decay)

    Where all bristles slide (x = 1) the curve has a kink (Svendenius, Tire Modeling and Friction Estimation, 2007).
    """

    stiffness: float
    """d mu / d s at no slip."""
    rest: float
    sliding: float
    decay: float

    def friction(self, slip: float) -> tuple[float, float]:
        """Friction and slope; see Tyre."""
        s = abs(slip)
        falling = (self.rest - self.sliding) * exp(-s / self.decay)
        m, m_slope = self.sliding + falling, -falling / self.decay
        x = self.stiffness * s / (3.0 * m)
        if x >= 1.0:
            mu, slope = m, m_slope
        else:
            x_slope = self.stiffness * (m - s * m_slope) / (3.0 * m * m)
            bristles = x * (3.0 - 3.0 * x + x * x)
            mu, slope = m * bristles, m_slope * bristles + m * 3.0 * (1.0 - x) ** 2 * x_slope
        return (mu if slip >= 0.0 else -mu), slope

    @property
    def peak(self) -> tuple[float, float]:
        """Peak, by trying slips."""
        slips = np.arange(_FINEST, 1.0, _FINEST).tolist()
        friction, slip = max((self.friction(slip)[0], slip) for slip in slips)
        return slip, friction


@dataclass(frozen=True)
class Scaled:
    """A tyre with the shape of another: its friction and the slips that go with it are multiplied."""

    tyre: Tyre
    friction_factor: float
    slip_factor: float

    def friction(self, slip: float) -> tuple[float, float]:
        """Friction and slope; see Tyre."""
        mu, slope = self.tyre.friction(slip / self.slip_factor)
        return self.friction_factor * mu, self.friction_factor / self.slip_factor * slope

    @property
    def peak(self) -> tuple[float, float]:
        """Peak."""
        slip, friction = self.tyre.peak
        return self.slip_factor * slip, self.friction_factor * friction


BRUSH_TYRES: dict[str, Tyre] = {
    "dry": Brush(30.0, 1.25, 0.7, 0.4),
    "wet": Brush(28.0, 0.95, 0.55, 0.25),
    "cobblestone": Brush(12.0, 1.15, 0.7, 0.6),
    "snow": Brush(15.0, 0.33, 0.2, 0.15),
}
"""Chosen for peaks between those of the published tyres, by road."""
