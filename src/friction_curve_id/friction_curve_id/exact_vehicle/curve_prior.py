"""Weak prior of a road before the first sample, from the family of the published Burckhardt roads."""

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CurvePrior:
    """Normal prior of q = (ln th1, ln th2, ln(th3 / th1)).

    The six published roads (dry and wet asphalt, dry concrete, dry and wet cobblestone, snow) have geometric means
    0.72, 27 and 0.39, and logarithmic standard deviations 0.79, 0.86 and 0.18. Level and steepness are widened to 1 (a
    factor 2.7 either way). th3 / th1 falls with th2 by -0.16 +- 0.07; a third of that slope is used, six roads
    being few. Level and steepness hardly matter once the slip has moved; th3 / th1 is what carries lambda_max until
    the slip has passed the peak.
    """

    theta_1: float = 0.72
    """Median of th1 [-], > 0."""
    theta_1_log_stddev: float = 1.0
    """> 0"""
    theta_2: float = 27.0
    """Median of th2 [-], > 0."""
    theta_2_log_stddev: float = 1.0
    """> 0"""
    ratio: float = 0.4
    """Median of th3 / th1 at the median th2 [-], > 0."""
    ratio_log_stddev: float = 0.18
    """Standard deviation of ln(th3 / th1) at a given th2, > 0."""
    ratio_log_slope: float = -0.05
    """d ln(th3 / th1) / d ln th2 [-]."""

    def __post_init__(self) -> None:
        """Refuse values that are not a distribution."""
        positive = (self.theta_1, self.theta_2, self.ratio)
        spread = (self.theta_1_log_stddev, self.theta_2_log_stddev, self.ratio_log_stddev)
        if not all(0.0 < value < np.inf for value in positive + spread) or not np.isfinite(self.ratio_log_slope):
            raise ValueError(f"medians and standard deviations must be > 0 and finite: {self}")

    @property
    def mean(self) -> Array:
        """Mean of q, shape (3,)."""
        return np.array([log(self.theta_1), log(self.theta_2), log(self.ratio)])

    @property
    def information(self) -> Array:
        """Inverse covariance of q, shape (3, 3)."""
        rows = np.diag([1.0 / self.theta_1_log_stddev, 1.0 / self.theta_2_log_stddev, 1.0 / self.ratio_log_stddev])
        rows[2, 1] = -self.ratio_log_slope / self.ratio_log_stddev
        return np.asarray(rows.T @ rows)
