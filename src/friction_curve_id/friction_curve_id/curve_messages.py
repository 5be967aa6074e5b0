"""Estimates of one wheel as friction_msgs/FrictionCurve, with what outlives a single estimate: restarts,
activation.
"""

from friction_msgs.msg import FrictionCurve
from std_msgs.msg import Header

from friction_curve_id.activation import ActivationMark
from friction_curve_id.interface import CurveEstimate, Reason, Refusal, RestartCause
from friction_runtime.stamps import NANOSECONDS, from_nanoseconds


class CurveMessages:
    """Makes the messages of one wheel."""

    def __init__(self, wheel: str, frame_id: str, method: str, activation_slip: float) -> None:
        """Name the wheel, its frame and the method; `activation_slip` [-] is that of ABS activation."""
        self._wheel = wheel
        self._frame_id = frame_id
        self._method = method
        self._activation = ActivationMark(activation_slip)
        self._restarts = 0
        self._cause = RestartCause.NONE

    def restart(self) -> None:
        """Forget the activation: what follows is another braking."""
        self._activation.reset()

    def message(self, stamp: int, answer: CurveEstimate | Refusal, slip: float, cause: RestartCause) -> FrictionCurve:
        """Make the message of one sample.

        Args:
            stamp: of the sample [ns].
            answer: of the estimator.
            slip: present slip [-] from the inputs, NaN where only the estimate knows it.
            cause: why the estimator was reset, where it says that it restarted on request.
        """
        refused = isinstance(answer, Refusal)
        estimate = CurveEstimate(0, slip, reason=answer.reason, text=answer.text) if refused else answer
        assert isinstance(estimate, CurveEstimate)
        if estimate.restarted:
            self._restarts += 1
            requested = estimate.restart_cause is RestartCause.REQUEST
            self._cause = cause if requested else estimate.restart_cause
        self._activation.update(stamp / NANOSECONDS, estimate.slip, estimate.lambda_max)
        message = _of(estimate)
        message.header = Header(stamp=from_nanoseconds(stamp), frame_id=self._frame_id)
        message.wheel = self._wheel
        message.method = self._method
        message.restarts = self._restarts
        message.restart_cause = int(self._cause)
        message.abs_active = self._activation.active
        message.at_activation = self._activation.at_activation
        message.lambda_max_at_activation = self._activation.lambda_max
        message.reason_text = estimate.text and f"{self._wheel}: {estimate.text}"
        return message


def _of(estimate: CurveEstimate) -> FrictionCurve:
    return FrictionCurve(
        theta_1=float(estimate.theta[0]),
        theta_2=float(estimate.theta[1]),
        theta_3=float(estimate.theta[2]),
        lambda_max=estimate.lambda_max,
        mu_max=estimate.mu_max,
        theta_1_stddev=float(estimate.theta_stddev[0]),
        theta_2_stddev=float(estimate.theta_stddev[1]),
        theta_3_stddev=float(estimate.theta_stddev[2]),
        lambda_max_stddev=estimate.lambda_max_stddev,
        mu_max_stddev=estimate.mu_max_stddev,
        slip=estimate.slip,
        mu=estimate.mu,
        slope=estimate.slope,
        slope_stddev=estimate.slope_stddev,
        probability_beyond_peak=estimate.probability_beyond_peak,
        samples=estimate.samples,
        restarted=estimate.restarted,
        valid=estimate.valid and estimate.reason is Reason.OK,
        reason=int(estimate.reason),
    )
