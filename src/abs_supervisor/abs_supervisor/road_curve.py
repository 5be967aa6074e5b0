"""The identified friction curve (2.13) as the law uses it, for one slip at a time."""

from math import exp, isfinite, log
from typing import Final

_SMALLEST, _LARGEST = 0.02, 0.5
"""[-] no road has its peak outside."""
_SHAPE_STEPS: Final = 8
"""Of the fixed point, which shrinks the error to a third or less each."""


class RoadCurve:
    """mu(slip) = theta_1 (1 - exp(-theta_2 slip)) - theta_3 slip, with its peak."""

    __slots__ = ("lambda_max", "mu_max", "theta_1", "theta_2", "theta_3")

    def __init__(self, theta_1: float, theta_2: float, theta_3: float, lambda_max: float) -> None:
        """Take the curve; `lambda_max` [-] is held in 0.02 to 0.5.

        Raises:
            ValueError: a value is not finite, or the curve does not rise from zero to a friction at its peak.
        """
        if not (isfinite(theta_1) and isfinite(theta_2) and isfinite(theta_3) and isfinite(lambda_max)):
            raise ValueError("a curve must be finite")
        self.theta_1, self.theta_2, self.theta_3 = theta_1, theta_2, theta_3
        self.lambda_max = min(max(lambda_max, _SMALLEST), _LARGEST)
        if not (theta_2 > 0.0 and self.friction(self.lambda_max) > 0.0):
            raise ValueError("a curve must rise")
        self.mu_max = self.friction(self.lambda_max)

    def friction(self, slip: float) -> float:
        """mu [-] at a slip, which is held in -1 to 1; odd in the slip."""
        s = min(abs(slip), 1.0)
        mu = self.theta_1 * (1.0 - exp(-self.theta_2 * s)) - self.theta_3 * s
        return mu if slip >= 0.0 else -mu

    def slope(self, slip: float) -> float:
        """Return d mu / d slip [-] at a slip, which is held in -1 to 1."""
        return self.theta_1 * self.theta_2 * exp(-self.theta_2 * min(abs(slip), 1.0)) - self.theta_3


def curve_through(lambda_max: float, mu_max: float) -> RoadCurve:
    """Return the Burckhardt curve of usual shape through a peak, for a tyre that another family describes better.

    With k = theta_2 lambda_max: k - ln k = -ln(0.4 lambda_max), which the roads of Table 8.1 follow.

    Args:
        lambda_max: [-]; the curve's is held in 0.02 to 0.5.
        mu_max: [-].

    Raises:
        ValueError: a value is not finite, or there is no friction.
    """
    if not (isfinite(lambda_max) and isfinite(mu_max)):
        raise ValueError("a peak must be finite")
    peak = min(max(lambda_max, _SMALLEST), _LARGEST)
    k = level = -log(0.4 * peak)
    for _ in range(_SHAPE_STEPS):
        k = level + log(k)
    fall = k * exp(-k)
    theta_1 = mu_max / (1.0 - exp(-k) - fall)
    return RoadCurve(theta_1, k / peak, theta_1 * fall / peak, peak)
