"""Inputs and outputs of every estimator of the friction curve.

    estimator = SomeEstimator(wheel, parameters)
    answer = estimator.update(Sample(time, wheel_speed, vehicle_speed, brake_torque))

An estimator takes one sample at a time, in order of time, and answers each with a `CurveEstimate` or with a `Refusal`
with the reason why there is none. A refused sample leaves the state as it was. Nothing here depends on ROS.

There is one convention for what is not known: a missing input is None, a number that a method cannot give is NaN, and
a sample that gives no estimate at all is a `Refusal`.
"""

from enum import IntEnum
from math import nan
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from vehicle_models.reason import Reason

Array = NDArray[np.float64]


class RestartCause(IntEnum):
    """Why the fit restarted; the values are those of friction_msgs/FrictionCurveDebug."""

    NONE = 0
    SURFACE = 1
    GAP = 2
    REQUEST = 3


class Sample(NamedTuple):
    """One sample of one wheel. Anything may be garbage: the estimator refuses what it cannot use."""

    time: float
    """Stamp [s]."""
    wheel_speed: float
    """Wheel speed omega [rad/s]."""
    vehicle_speed: float | None
    """Vehicle speed v [m/s], None where there is no measurement."""
    brake_torque: float | None
    """Brake torque T_b [N m], >= 0 in braking, None where it is missing."""


class Refusal(NamedTuple):
    """Why a sample gave no estimate."""

    reason: Reason
    text: str


UNKNOWN_THETA: Array = np.full(3, nan)
UNKNOWN_THETA_COVARIANCE: Array = np.full((3, 3), nan)
"""theta of a method with another model, and its covariance."""
UNKNOWN_THETA.flags.writeable = UNKNOWN_THETA_COVARIANCE.flags.writeable = False


class CurveEstimate(NamedTuple):
    """A friction curve after one more sample. NaN stands for what the method cannot give."""

    samples: int
    """Samples in the present fit."""
    slip: float
    """Present slip [-] of the method."""
    lambda_max: float = nan
    """Slip at the peak [-]; NaN where the curve has no peak in (0, 1)."""
    mu_max: float = nan
    """Friction coefficient at the peak [-]."""
    lambda_max_stddev: float = nan
    mu_max_stddev: float = nan
    theta: Array = UNKNOWN_THETA
    """Burckhardt parameters of (2.13), shape (3,)."""
    theta_covariance: Array = UNKNOWN_THETA_COVARIANCE
    """Covariance of theta [-], shape (3, 3)."""
    mu: float = nan
    """Friction coefficient of the fitted curve at the present slip [-]."""
    slope: float = nan
    """d mu / d slip of the fitted curve at the present slip [-]."""
    slope_stddev: float = nan
    probability_beyond_peak: float = nan
    """Probability that the present slip is beyond the peak, 0..1."""
    restart_cause: RestartCause = RestartCause.NONE
    """Why the fit restarted at this sample, NONE where it did not."""
    reason: Reason = Reason.NOT_READY
    """Why lambda_max and mu_max may not be used together, OK where they may."""
    text: str = ""
    """The same in words."""
    slip_stddev: float = nan
    """Standard deviation of the slip [-]; NaN where the method has none."""
    mu_max_known: bool = False
    """Whether mu_max may be used where lambda_max may not."""

    @property
    def valid(self) -> bool:
        """Whether lambda_max and mu_max may be used."""
        return self.reason is Reason.OK

    @property
    def mu_max_valid(self) -> bool:
        """Whether mu_max may be used."""
        return self.valid or self.mu_max_known

    @property
    def restarted(self) -> bool:
        """Whether the fit restarted at this sample."""
        return self.restart_cause is not RestartCause.NONE


class CurveEstimator(Protocol):
    """An estimator of the friction curve of one wheel, made from its parameters."""

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        ...

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        ...
