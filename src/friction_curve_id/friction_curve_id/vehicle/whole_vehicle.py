"""The friction curve from the vehicle's deceleration and the slips of all wheels: no brake torque is needed.

    -a_x / g - drag = sum over wheels of s_i mu(slip_i; theta),   s_i = Fz_i / sum of Fz = s_i0 + t_i (-a_x / g),

with the load shares s_i0 of the standing vehicle and the load transfer t_i. It holds for the whole vehicle on
one road surface. Two effects are known to distort the slips of real sensors, and both are in the model:
- speed reference, wheel speeds and acceleration are not of the same instant. A reference that is ahead by tau moves the
  slip by tau (1 - slip) a_x / v, at 11 m/s^2 and 10 m/s some 0.01 for 10 ms; wheel speeds that are ahead move it by as
  much the other way and along d slip/dt; an acceleration that is ahead is both of them late. The three tau are
  nuisance unknowns with a prior;
- a tyre answers to a change of slip over its relaxation length L: the slip is filtered by exp(-distance / L). ln L is
  another nuisance unknown, linearised around that of the vehicle file.

The fit is robust (Huber) maximum a posteriori in (ln th1, ln th2, th3, three tau, ln L) over the samples of one
braking, two Gauss-Newton steps per sample. Neighbouring residuals are alike (suspension, ABS cycles), so the
information of the samples is divided by `samples_per_information` before it becomes an interval.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.curve.burckhardt_curve import (
    UNKNOWNS_HIGH,
    UNKNOWNS_LOW,
    BurckhardtCurve,
    theta_per_unknown,
    to_theta,
)
from friction_curve_id.curve.fitted_curve import FittedCurve, samples_per_information
from friction_curve_id.curve.validity import ValidityLimits
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from friction_curve_id.vehicle.vehicle_samples import (
    VehiclePoint,
    VehicleSample,
    VehicleSamples,
    WholeVehicleParameters,
    relaxation_spread,
)
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_PRIOR_MEAN = np.array([np.log(0.8), np.log(25.0), 0.4, 0.0, 0.0, 0.0, 0.0])
_PRIOR_INFORMATION = np.eye(len(_PRIOR_MEAN))
"""Of the unknowns over the standard deviations of the prior."""
_PRIOR_STDDEV = np.array([0.8, 1.0, 0.5])
"""Standard deviations of ln th1, ln th2, th3; that of the tau is a parameter, that of ln L is in the vehicle file."""
_LOW = np.append(UNKNOWNS_LOW, [-0.1, -0.1, -0.1, -2.0])
_HIGH = np.append(UNKNOWNS_HIGH, [0.1, 0.1, 0.1, 2.0])
_LEAST_NOISE = 0.01
"""Floor of the residuals' standard deviation [-]: a pitching vehicle's accelerometer is no better."""
_HUBER = 1.345
_STEPS = 2
_LONGEST_STEP = 1.0
"""Longest Gauss-Newton step, in standard deviations of the prior."""
_SAMPLES_BEYOND = 5
"""Samples that must lie beyond the peak before it counts as passed."""
_LIMITS = ValidityLimits(max_relative_stddev=0.25)
"""Limits of a valid peak. Timing and relaxation alone leave a relative deviation of 0.13 on a measured stop."""
_FEWEST_SAMPLES = 20
_WINDOW = 400


class WholeVehicle:
    """Curve of the whole vehicle, one sample at a time."""

    def __init__(self, vehicle: Vehicle, parameters: WholeVehicleParameters = WholeVehicleParameters()) -> None:
        """Wait for the first braking."""
        self._samples = VehicleSamples(vehicle, parameters)
        timing = [parameters.timing_stddev] * 3
        self._prior_stddev = np.concatenate([_PRIOR_STDDEV, timing, [relaxation_spread(vehicle)]])
        self._points: deque[VehiclePoint] = deque(maxlen=_WINDOW)
        self._unknowns = _PRIOR_MEAN.copy()
        self._cause = RestartCause.NONE

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._samples.reset()
        self._clear()
        self._cause = RestartCause.REQUEST

    def update(self, sample: VehicleSample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        point = self._samples.update(sample)
        if isinstance(point, Refusal):
            return point
        if point.starts_braking or point.after_gap:
            if point.after_gap and self._points and self._cause is RestartCause.NONE:
                self._cause = RestartCause.GAP
            self._clear()
        self._points.append(point)
        if len(self._points) < _FEWEST_SAMPLES:
            return Refusal(Reason.NOT_READY, f"{len(self._points)} of {_FEWEST_SAMPLES} samples")
        covariance = self._fit()
        theta = to_theta(self._unknowns[:3])
        scale = theta_per_unknown(theta)
        mean_slips = np.sort([float(each.shares @ each.slips) for each in self._points])
        curve = FittedCurve(BurckhardtCurve(), theta, covariance[:3, :3] * np.outer(scale, scale))
        reached = float(mean_slips[-_SAMPLES_BEYOND])
        slip = float(point.shares @ point.slips)
        estimate = curve.estimate(slip, len(self._points), reached, _LIMITS)
        cause, self._cause = self._cause, RestartCause.NONE
        return estimate._replace(restart_cause=cause)

    def _clear(self) -> None:
        self._points.clear()
        self._unknowns = _PRIOR_MEAN.copy()

    def _fit(self) -> Array:
        """Improve the unknowns and return their covariance, shape (7, 7)."""
        slips = np.array(
            [
                (p.slips, p.slips_per_second, p.slip_rates - p.slips_per_second, -p.slip_rates, p.slips_per_length)
                for p in self._points
            ]
        )
        shares = np.array([point.shares for point in self._points])
        frictions = np.array([point.friction for point in self._points])
        for _ in range(_STEPS):
            residuals, rows = self._linearise(slips, shares, frictions)
            noise = max(1.4826 * float(np.median(np.abs(residuals))), _LEAST_NOISE)
            weights = np.minimum(1.0, _HUBER * noise / np.maximum(np.abs(residuals), 1e-9))
            information = (rows * weights[:, np.newaxis]).T @ rows / noise**2
            pull = (_PRIOR_MEAN - self._unknowns) / self._prior_stddev
            gradient = rows.T @ (weights * residuals) / noise**2 + pull
            step = np.linalg.solve(information + _PRIOR_INFORMATION, gradient)
            step /= max(1.0, float(np.max(np.abs(step))) / _LONGEST_STEP)
            self._unknowns = np.clip(self._unknowns + step * self._prior_stddev, _LOW, _HIGH)
        information /= samples_per_information(weights * residuals)
        scale = np.outer(self._prior_stddev, self._prior_stddev)
        return np.asarray(np.linalg.inv(information + _PRIOR_INFORMATION) * scale, dtype=np.float64)

    def _linearise(self, slips: Array, shares: Array, frictions: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and rows of the model per standard deviation of the prior, shape (n, 7).

        `slips` holds slip and its four derivatives of n samples of w wheels, shape (n, 5, w).
        """
        theta = to_theta(self._unknowns[:3])
        shifted = slips[:, 0] + np.einsum("k,nkw->nw", self._unknowns[3:], slips[:, 1:])
        residuals = frictions - np.sum(shares * burckhardt.friction(theta, shifted), axis=1)
        curve = np.einsum("nw,nwk->nk", shares, burckhardt.gradient(theta, shifted)) * theta_per_unknown(theta)
        nuisance = np.einsum("nw,nkw->nk", shares * burckhardt.slope(theta, shifted), slips[:, 1:])
        return residuals, np.column_stack([curve, nuisance]) * self._prior_stddev
