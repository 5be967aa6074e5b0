"""Families of friction curves in units of their peak: f(x) with x = slip / lambda_max, and f(1) = 1, f'(1) = 0.

Burckhardt (2.13) has one parameter of shape, k = theta_2 lambda_max:

    f(x) = (1 - exp(-k x) - k exp(-k) x) / (1 - exp(-k) - k exp(-k)),    k - ln k = -ln(0.4 lambda_max) + u

where 0.4 is theta_3 / theta_1 of the published roads and u its logarithmic deviation (with the opposite sign). The
magic formula (Bakker, Nyborg and Pacejka 1987) has two, C and E:

    f(x) = sin(C atan(y - E (y - atan y))),    y = x y_1,    C atan(y_1 - E (y_1 - atan y_1)) = pi / 2

Both are odd in x.
"""

from dataclasses import dataclass
from enum import Enum
from math import atan, exp, log, pi, tan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_THETA_RATIO = 0.4
_LEAST_K_EQUATION = 1.05
"""k - ln k is at least 1; near it the family has no distinct peak."""
_C_RANGE = (1.15, 2.6)


class Family(Enum):
    """Formula of the friction curve."""

    BURCKHARDT = "burckhardt"
    PACEJKA = "pacejka"


@dataclass(frozen=True)
class ShapePrior:
    """Means and standard deviations of the two parameters of shape of a family."""

    mean: tuple[float, float]
    stddev: tuple[float, float]


SHAPE_PRIORS = {
    Family.BURCKHARDT: ShapePrior((0.0, 0.0), (0.45, 0.0)),
    Family.PACEJKA: ShapePrior((1.87, -2.0), (0.25, 1.3)),
}
"""Burckhardt: u, unused. Pacejka: C, ln(1 - E), held above -4.5. Published curves lie within two deviations."""
PUBLISHED_ROADS = ShapePrior((0.0, 0.0), (0.18, 0.0))
"""Burckhardt alone: u as on his six roads, as for the default (CurvePrior). No tyre of another formula is to be met."""


@dataclass(frozen=True)
class CurveValues:
    """The curve at n slips, with its derivatives; all arrays have the shape of x."""

    value: Array
    """f."""
    slope: Array
    """d f / d x."""
    by_log_peak: Array
    """d f / d ln lambda_max at constant x."""
    by_shape: tuple[Array, Array]
    """d f / d shape."""


def curve_values(family: Family, log_peak: float, shape: tuple[float, float], x: Array) -> CurveValues:
    """Evaluate the curve.

    Args:
        family: its formula.
        log_peak: ln lambda_max.
        shape: parameters of shape, see SHAPE_PRIORS.
        x: slip / lambda_max, any shape.
    """
    return _burckhardt(log_peak, shape[0], x) if family is Family.BURCKHARDT else _pacejka(shape, x)


def burckhardt_k(log_peak: float, u: float) -> float:
    """theta_2 lambda_max of a Burckhardt curve, > 1: the larger root of k - ln k = -ln(0.4 lambda_max) + u."""
    c = max(-log(_THETA_RATIO) - log_peak + u, _LEAST_K_EQUATION)
    k = c + log(c) + 0.5
    for _ in range(8):
        k -= (k - log(k) - c) / (1.0 - 1.0 / k)
    return k


def _burckhardt(log_peak: float, u: float, x: Array) -> CurveValues:
    k = burckhardt_k(log_peak, u)
    size, sign = np.abs(x), np.where(x < 0.0, -1.0, 1.0)
    decay, at_peak = np.exp(-k * size), exp(-k)
    scale = 1.0 / (1.0 - at_peak - k * at_peak)
    value = (1.0 - decay - k * at_peak * size) * scale
    slope = k * (decay - at_peak) * scale
    by_k = (size * decay - (1.0 - k) * at_peak * size) * scale - value * (k * at_peak) * scale
    by_u = sign * by_k * (k / (k - 1.0))
    clamped = -log(_THETA_RATIO) - log_peak + u <= _LEAST_K_EQUATION
    if clamped:
        by_u = np.zeros_like(by_u)
    return CurveValues(sign * value, slope, -by_u, (by_u, np.zeros_like(by_u)))


def _pacejka(shape: tuple[float, float], x: Array) -> CurveValues:
    c, stretch = min(max(shape[0], _C_RANGE[0]), _C_RANGE[1]), exp(min(max(shape[1], -4.5), 2.0))
    at_peak = tan(0.5 * pi / c)
    y1 = at_peak
    for _ in range(12):  # (1 - E) y + E atan y = tan(pi / (2 C)): rising and nearly straight
        gradient = stretch + (1.0 - stretch) / (1.0 + y1 * y1)
        y1 = max(y1 - (stretch * y1 + (1.0 - stretch) * atan(y1) - at_peak) / gradient, 1e-3)
    gradient = stretch + (1.0 - stretch) / (1.0 + y1 * y1)
    y1_by_c = -(1.0 + at_peak * at_peak) * 0.5 * pi / (c * c) / gradient
    y1_by_stretch = -(y1 - atan(y1)) / gradient
    y = x * y1
    angle_y = np.arctan(y)
    z = stretch * y + (1.0 - stretch) * angle_y
    z_by_y = stretch + (1.0 - stretch) / (1.0 + y * y)
    angle = np.arctan(z)
    cosine = np.cos(c * angle)
    by_z = cosine * c / (1.0 + z * z)
    by_y = by_z * z_by_y
    by_c = cosine * angle + by_y * x * y1_by_c
    by_stretch = (by_z * (y - angle_y) + by_y * x * y1_by_stretch) * stretch
    return CurveValues(np.sin(c * angle), by_y * y1, np.zeros_like(y), (by_c, by_stretch))
