"""The identified friction curve (2.13) as the law uses it, for one slip at a time."""

from math import exp, isfinite

_SMALLEST, _LARGEST = 0.02, 0.5
"""[-] no road has its peak outside."""


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
