"""Validity of the peak of a fitted curve: the same limits for all methods."""

from dataclasses import dataclass
from math import isfinite

from vehicle_models.reason import Reason


@dataclass(frozen=True)
class ValidityLimits:
    """Limits within which lambda_max and mu_max may be used."""

    max_relative_stddev: float = 0.1
    """Largest relative standard deviation of lambda_max [-], > 0."""

    def judge(self, slip_span: tuple[float, float], lambda_max: float, stddev: float) -> tuple[Reason, str]:
        """Return why the peak may not be used, OK if it may, and the same in words.

        Args:
            slip_span: smallest and largest slip in the fit [-]. The smallest is 0 for a method that starts from there.
            lambda_max: estimate of the slip at the peak [-], NaN for no peak.
            stddev: standard deviation of lambda_max [-], NaN where it is unknown.
        """
        if not isfinite(lambda_max):
            return Reason.NO_PEAK, "the fitted curve has no peak in (0, 1)"
        smallest, largest = slip_span
        if largest < lambda_max:
            return (
                Reason.PEAK_NOT_PASSED,
                f"waiting for slip beyond the peak near {lambda_max:.3f}: so far {largest:.3f}",
            )
        if smallest > lambda_max:
            return Reason.UNCERTAIN, f"waiting for slip below the peak: all are beyond it, from {smallest:.3f} on"
        if not stddev <= self.max_relative_stddev * lambda_max:
            return (
                Reason.UNCERTAIN,
                f"waiting for slips around the peak: lambda_max is {lambda_max:.3f} +- {stddev:.3f}",
            )
        return Reason.OK, ""
