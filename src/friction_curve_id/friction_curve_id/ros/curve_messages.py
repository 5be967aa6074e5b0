"""Estimates of one wheel as FrictionCurve and FrictionCurveDebug, with the state that spans estimates: restarts and
activation.
"""

from math import nan

from friction_msgs.msg import FrictionCurve, FrictionCurveDebug

from friction_curve_id.activation import ActivationMark
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from friction_runtime.messages import header_at, validity
from friction_runtime.processor import Level, Output, level_of
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason

_NO_ESTIMATE = CurveEstimate(samples=0, slip=nan)
_QUIET = (Reason.OK, Reason.NOT_READY, Reason.PEAK_NOT_PASSED, Reason.LOW_SPEED, Reason.NO_EXCITATION)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_SLIP, Reason.NO_PRESSURE, Reason.NO_ACCELERATION)
"""Reasons that do not go away by waiting."""


def health_of(message: FrictionCurve) -> Level:
    """Return the level of diagnostics that the reason of a message has."""
    return level_of(message.validity.reason, _QUIET, _BROKEN)


class CurveMessages:
    """Makes the messages of one wheel."""

    def __init__(self, wheel: str, frame_id: str, method: str, activation_slip: float, highest_mu: float) -> None:
        """Name the wheel, its frame and the method.

        Args:
            wheel: its name.
            frame_id: its frame.
            method: name of the method.
            activation_slip: slip of ABS activation [-].
            highest_mu: largest mu_max [-] that is valid.
        """
        self._wheel = wheel
        self._topic = f"{wheel}/friction_curve"
        self._debug_topic = f"{self._topic}_debug"
        self._frame_id = frame_id
        self._method = method
        self._activation = ActivationMark(activation_slip)
        self._highest_mu = highest_mu
        self._restarts = 0
        self._cause = RestartCause.NONE

    def restart(self) -> None:
        """Forget the activation before another braking."""
        self._activation.reset()

    @property
    def topics(self) -> dict[str, type]:
        """Topics and types of the outputs."""
        return {self._topic: FrictionCurve, self._debug_topic: FrictionCurveDebug}

    def outputs(self, stamp: int, answer: CurveEstimate | Refusal, slip: float, cause: RestartCause) -> list[Output]:
        """Make the curve of one sample, then its debug message.

        Args:
            stamp: stamp of the sample [ns].
            answer: answer of the estimator.
            slip: present slip [-] from the inputs, NaN where only the estimate has it.
            cause: why the estimator was reset; used where the answer reports a restart on request.
        """
        reason, text = answer.reason, answer.text
        if isinstance(answer, Refusal):
            estimate = _NO_ESTIMATE
        else:
            estimate = _of_a_tyre(answer, self._highest_mu)
            reason, text, slip = estimate.reason, estimate.text, estimate.slip
        if estimate.restarted:
            self._restarts += 1
            requested = estimate.restart_cause is RestartCause.REQUEST
            self._cause = cause if requested else estimate.restart_cause
        self._activation.update(stamp / NANOSECONDS, slip, estimate.lambda_max)
        header = header_at(stamp, self._frame_id)
        message = FrictionCurve()
        _set_curve(message, estimate)
        message.header = header
        message.wheel = self._wheel
        message.method = self._method
        message.slip = slip
        message.restarts = self._restarts
        message.validity = validity(self._wheel, reason, text)
        debug = FrictionCurveDebug()
        debug.header = header
        debug.wheel = self._wheel
        debug.restarted = estimate.restarted
        debug.restart_cause = int(self._cause)
        debug.abs_active = self._activation.active
        debug.at_activation = self._activation.at_activation
        debug.lambda_max_at_activation = self._activation.lambda_max
        return [(self._topic, message), (self._debug_topic, debug)]


def _of_a_tyre(answer: CurveEstimate, highest_mu: float) -> CurveEstimate:
    """Return the answer without a peak that no tyre has, and without a mu_max that is not valid."""
    if answer.lambda_max >= 1.0 or answer.lambda_max <= 0.0:
        none = answer._replace(lambda_max=nan, mu_max=nan, lambda_max_stddev=nan, mu_max_stddev=nan)
        said = answer.text or f"the fitted peak is at a slip of {answer.lambda_max:.3g}, not in (0, 1)"
        return none._replace(reason=Reason.NO_PEAK if answer.valid else answer.reason, text=said)
    if answer.valid and answer.mu_max > highest_mu:
        answer = answer._replace(reason=Reason.UNCERTAIN, text=f"no tyre has a mu_max of {answer.mu_max:.2f}")
    if not (answer.mu_max_valid and answer.mu_max <= highest_mu):
        return answer._replace(mu_max=nan, mu_max_stddev=nan)
    return answer


def _set_curve(message: FrictionCurve, estimate: CurveEstimate) -> None:
    message.theta_1, message.theta_2, message.theta_3 = estimate.theta.tolist()
    message.theta_covariance = estimate.theta_covariance.ravel()
    message.lambda_max = estimate.lambda_max
    message.mu_max = estimate.mu_max
    message.lambda_max_stddev = estimate.lambda_max_stddev
    message.mu_max_stddev = estimate.mu_max_stddev
    message.slip_stddev = estimate.slip_stddev
    message.mu = estimate.mu
    message.slope = estimate.slope
    message.slope_stddev = estimate.slope_stddev
    message.probability_beyond_peak = estimate.probability_beyond_peak
    message.samples = estimate.samples
