"""Validity of the peak of a fitted curve: the same limits for all methods."""

from dataclasses import dataclass
from math import isfinite

from vehicle_models.reason import Reason


@dataclass(frozen=True)
class ValidityLimits:
    """Limits within which lambda_max and mu_max may be used."""

    min_samples: int = 0
    """Least samples in the fit; 0 for a method that waits for its samples before it fits."""
    max_relative_stddev: float = 0.1
    """Largest relative standard deviation of lambda_max [-], > 0."""

    def judge(
        self, samples: int, slip_span: tuple[float, float], lambda_max: float, stddev: float
    ) -> tuple[Reason, str]:
        """Return why the peak may not be used, OK if it may, and the same in words.

        Args:
            samples: number of samples in the fit.
            slip_span: smallest and largest slip in the fit [-]. The smallest is 0 for a method that starts from there.
            lambda_max: estimate of the slip at the peak [-], NaN for no peak.
            stddev: standard deviation of lambda_max [-], NaN where it is unknown.
        """
        if samples < self.min_samples:
            return Reason.NOT_READY, f"{samples} of {self.min_samples} samples"
        if not isfinite(lambda_max):
            return Reason.NO_PEAK, "the fitted curve has no peak in (0, 1)"
        smallest, largest = slip_span
        if largest < lambda_max:
            text = f"slip has not passed the peak: it reached {largest:.3f}, the peak is expected at {lambda_max:.3f}"
            return Reason.PEAK_NOT_PASSED, text
        if smallest > lambda_max:
            return Reason.UNCERTAIN, f"all slips lie beyond the peak, from {smallest:.3f} on"
        if not stddev <= self.max_relative_stddev * lambda_max:
            return Reason.UNCERTAIN, f"lambda_max {lambda_max:.3f} has a standard deviation of {stddev:.3f}"
        return Reason.OK, ""
