"""Friction mu of a tyre over its slip s: Burckhardt, Pacejka, and families that no estimator assumes."""

from dataclasses import dataclass
from math import atan, cos, exp, log, pi, sin, tan
from typing import Protocol

import numpy as np


class Tyre(Protocol):
    """Steady friction of a tyre on a road; mu(-s) = -mu(s)."""

    def friction(self, slip: float) -> tuple[float, float]:
        """Friction mu [-] and its slope d mu / d s [-] at a slip [-], braking positive."""

    @property
    def peak(self) -> tuple[float, float]:
        """Slip lambda_max [-] and friction mu_max [-] of the peak."""


@dataclass(frozen=True)
class Burckhardt:
    """mu = th1 (1 - exp(-th2 s)) - th3 s (Kiencke and Nielsen, Automotive Control Systems; Table 8.1)."""

    th1: float
    th2: float
    th3: float

    def friction(self, slip: float) -> tuple[float, float]:
        """Friction and slope; see Tyre."""
        decayed = self.th1 * exp(-self.th2 * abs(slip))
        friction = self.th1 - decayed - self.th3 * abs(slip)
        return (friction if slip >= 0.0 else -friction), self.th2 * decayed - self.th3

    @property
    def peak(self) -> tuple[float, float]:
        """Peak, where the slope is zero: exp(-th2 s) = th3 / (th1 th2)."""
        slip = log(self.th1 * self.th2 / self.th3) / self.th2
        return slip, self.friction(slip)[0]


@dataclass(frozen=True)
class Pacejka:
    """mu = D sin(C atan(y - E (y - atan y))), y = B s (Pacejka, Tire and Vehicle Dynamics), with C > 1 for a peak."""

    B: float
    C: float
    D: float
    E: float

    def friction(self, slip: float) -> tuple[float, float]:
        """Friction and slope; see Tyre."""
        y = self.B * slip
        bent = y - self.E * (y - atan(y))
        angle = self.C * atan(bent)
        inner = self.B * (1.0 - self.E + self.E / (1.0 + y * y))
        return self.D * sin(angle), self.D * cos(angle) * self.C * inner / (1.0 + bent * bent)

    @property
    def peak(self) -> tuple[float, float]:
        """Peak, where C atan(y - E (y - atan y)) is a right angle; by bisection, for E <= 1."""
        target, low, high = tan(pi / (2.0 * self.C)), 0.0, 1e3
        for _ in range(100):
            y = 0.5 * (low + high)
            low, high = (low, y) if y - self.E * (y - atan(y)) > target else (y, high)
        return low / self.B, self.D


TYRES: dict[str, dict[str, Tyre]] = {
    "burckhardt": {
        "dry": Burckhardt(1.2801, 23.99, 0.52),
        "wet": Burckhardt(0.857, 33.822, 0.347),
        "cobblestone": Burckhardt(1.3713, 6.4565, 0.6691),
        "snow": Burckhardt(0.1946, 94.129, 0.0646),
    },
    "pacejka": {
        "dry": Pacejka(10.0, 1.9, 1.0, 0.97),
        "wet": Pacejka(12.0, 2.3, 0.82, 1.0),
        # none is in common use: one with the peak of Burckhardt's
        "cobblestone": Pacejka(4.07, 1.7, 1.0, 0.5),
        "snow": Pacejka(5.0, 2.0, 0.3, 1.0),
    },
}
"""Published tyres by family and road."""


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


STEEP_TYRES: dict[str, Tyre] = {
    "dry": Pacejka(12.0, 1.9, 1.0, 0.0),
    "wet": Pacejka(14.0, 1.88, 0.7, 0.0),
    "cobblestone": Pacejka(2.5, 2.0, 1.0, 0.0),
    "snow": Pacejka(18.0, 1.87, 0.25, 0.0),
}
"""Chosen to lose two thirds of their friction when they lock, on cobblestone a third."""
FAMILIES: dict[str, dict[str, Tyre]] = {**TYRES, "steep": STEEP_TYRES}
"""Families with which a car may be driven."""
