"""The default estimator: full-information maximum a posteriori fit of the curve, one update a sample.

What it fits is in `banded_normal_equations`, what it knows beforehand in `curve_prior`. Samples wait in the window
until the brake or the wheel moves (`excitation`); then one warm-started Gauss-Newton step a sample follows, a second or
third where the curve still moves much. A full window folds its oldest samples into `past_evidence`, which fades.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.banded_normal_equations import (
    MeasurementNoise,
    NormalEquations,
    OutlierThresholds,
    Solution,
    assemble,
    fold,
    solve,
)
from friction_curve_id.braking_window import SET_ASIDE, BrakingWindow
from friction_curve_id.curve_prior import CurvePrior
from friction_curve_id.curve_uncertainty import ValidityLimits, describe
from friction_curve_id.excitation import is_driven, is_excited, is_released, wheel_trend
from friction_curve_id.interface import CurveEstimate, Reason, Refusal, RestartCause, Sample, WheelParameters
from friction_curve_id.past_evidence import MOMENTUM, WHEEL_SPEED, momentum_evidence, no_evidence
from friction_curve_id.prediction import predict
from friction_curve_id.sample_gate import Admission, GateParameters, SampleGate
from friction_curve_id.surface_change import LONGEST_OUTLIER, SurfaceChangeMonitor
from friction_curve_id.torque_watch import TorqueWatch

Array = NDArray[np.float64]

_LEAD_IN = 20
"""Samples that wait for the brake or the wheel to move."""
_SHORT_LEAD_IN = 3
"""So many of them where the engine moves the wheel: its torque is not known."""
_QUIET = 40
"""So many samples of constant torque and slip say nothing new."""
_RELEASED = 10
"""So many samples without brake torque and slip end the braking."""
_QUIET_SLIP_SPAN = 0.002
_LONGEST_STEP = 0.7
"""Of any coordinate of q in one iteration: a factor two."""
_HALVINGS = 4
"""Of a step that raises the cost."""
_SETTLED = 0.1
"""A step of q below this needs no further iteration."""
_FARTHEST = 8.0
"""q stays within so many prior standard deviations of the prior mean."""
_NO_OUTLIERS = OutlierThresholds(1e6, 1e6, 1e6)
_START_SPEED_DOUBT = 0.1
"""Added to the standard deviation of u at a change of surface [m/s]."""
_DRIVEN_ACCELERATION = 5.0
"""Standard deviation of the acceleration between brakings [m/s^2]: the torque of the engine is not measured."""
_START_SPEED_STDDEV = 10.0
"""Of the first guess of u [m/s]: weak, whatever the wheel does at the start."""


@dataclass(frozen=True)
class DefaultParameters:
    """All parameters of the default estimator."""

    wheel: WheelParameters = field(default_factory=WheelParameters)
    gate: GateParameters = field(default_factory=GateParameters)
    noise: MeasurementNoise = field(default_factory=MeasurementNoise)
    prior: CurvePrior = field(default_factory=CurvePrior)
    thresholds: OutlierThresholds = field(default_factory=OutlierThresholds)
    limits: ValidityLimits = field(default_factory=ValidityLimits)
    window: int = 150
    """Most samples in the window, >= 60; the oldest third is folded when it is full."""
    memory: float = 2.0
    """Time constant with which folded samples are forgotten [s], > 0."""
    acceleration_error: float = 0.3
    """What the model leaves out of the vehicle's acceleration [m/s^2], > 0: drag, slope, errors of its parameters."""

    def __post_init__(self) -> None:
        """Refuse what makes no estimator."""
        if self.window < 60 or not (self.memory > 0.0 and self.acceleration_error > 0.0):
            raise ValueError("window must be >= 60, memory and acceleration_error > 0")


class DefaultEstimator:
    """CurveEstimator of one wheel."""

    def __init__(self, parameters: DefaultParameters = DefaultParameters()) -> None:
        """Know nothing but the prior."""
        self._p = parameters
        self._gate = SampleGate(parameters.wheel.radius, parameters.gate)
        self._window = BrakingWindow(parameters.wheel, parameters.window)
        self._monitor = SurfaceChangeMonitor()
        self._torque_watch = TorqueWatch(parameters.noise.torque)
        self._prior_mean = parameters.prior.mean
        self._prior_information = parameters.prior.information
        self._prior_reach = _FARTHEST * np.sqrt(np.diag(np.linalg.inv(self._prior_information)))
        self._cause = RestartCause.NONE
        self._forget()

    def reset(self) -> None:
        """Forget everything; the next estimate says that it restarted on request."""
        self._gate.reset()
        self._forget()
        self._cause = RestartCause.REQUEST

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        admission = self._gate.admit(sample)
        if isinstance(admission, Refusal):
            return admission
        assert sample.brake_torque is not None
        try:
            return self._take(sample, sample.brake_torque, admission)
        except np.linalg.LinAlgError as error:
            self._forget()
            return Refusal(Reason.BAD_INPUT, f"the fit failed and begins anew: {error}")

    def _forget(self) -> None:
        self._window.clear()
        self._monitor.reset()
        self._torque_watch.reset()
        self._suspect = False
        self._fitting = False
        self._q = self._prior_mean.copy()
        self._momentum_speed = 0.0
        self._covariance = np.zeros((5, 5))
        self._past = no_evidence()
        self._folded_at = 0.0
        self._samples = 0
        self._smallest_slip, self._largest_slip = 1.0, 0.0

    def _take(self, sample: Sample, torque: float, admission: Admission) -> CurveEstimate | Refusal:
        since = sample.time - self._window.time[self._window.count - 1] if self._window.count else 0.0
        if admission is Admission.AFTER_GAP or since > self._p.gate.max_gap:
            self._pause(sample.time)
        if self._fitting:
            return self._follow(sample, torque)
        return self._wait(sample, torque)

    def _pause(self, time: float) -> None:
        """After a gap the dead reckoning starts anew; what is known of the curve fades with the length of the gap."""
        if self._fitting:
            self._summarise()
        if self._samples:
            self._cause = RestartCause.GAP
        self._past = self._past.without(MOMENTUM)
        if time < self._folded_at:
            self._past = no_evidence()
        self._window.clear()
        self._monitor.reset()
        self._torque_watch.reset()
        self._suspect = False
        self._samples = 0

    def _summarise(self) -> None:
        """Fold all samples but the newest, which stays in the window unused, and stop fitting."""
        window, last = self._window, self._window.count - 1
        x = np.array([*self._q, self._momentum_speed, window.wheel_speed[last]])
        if last > 0:
            self._past = fold(self._equations(oldest=last), last, x).without(WHEEL_SPEED)
        self._folded_at = float(window.time[last])
        window.drop_oldest(last)
        self._monitor.reset()
        self._fitting = False

    def _wait(self, sample: Sample, torque: float) -> CurveEstimate | Refusal:
        window, wheel = self._window, self._p.wheel
        if sample.vehicle_speed is None and sample.wheel_speed * wheel.radius < self._p.gate.min_speed:
            return Refusal(Reason.LOW_SPEED, f"wheel speed {sample.wheel_speed:.3g} rad/s is low, no speed is measured")
        window.append(sample.time, sample.wheel_speed, sample.vehicle_speed, torque, sample.wheel_speed)
        if window.count > _LEAD_IN:
            window.drop_oldest(1)
        n, noise = window.count, self._p.noise
        trend = wheel_trend(window.time[:n], window.measured_wheel_speed[:n], noise.wheel_speed)
        if not is_excited(trend, window.torque[:n], noise.wheel_speed, noise.torque):
            if is_driven(trend, window.torque[:n], wheel):
                window.drop_oldest(n - _SHORT_LEAD_IN)
            return Refusal(Reason.NO_EXCITATION, "torque and slip are constant: the curve cannot be seen")
        self._start()
        return self._publish()

    def _start(self) -> None:
        """Begin to fit the samples that waited."""
        window, p = self._window, self._p
        n = window.count
        age = max(float(window.time[0]) - self._folded_at, 0.0)
        self._past = self._past.loosened(MOMENTUM, (_DRIVEN_ACCELERATION * age) ** 2).aged(age, p.memory)
        if not self._past.information.any():
            if self._samples:
                self._cause = RestartCause.GAP
            self._q = self._prior_mean.copy()
            self._samples = 0
            self._smallest_slip, self._largest_slip = 1.0, 0.0
        if self._past.information[MOMENTUM, MOMENTUM] < _START_SPEED_STDDEV**-2:
            self._guess_momentum()
        self._samples += n
        self._fitting = True
        self._iterate(at_most=6)

    def _guess_momentum(self) -> None:
        """First guess of u: a wheel on the stable side of the curve, and the measured speeds."""
        window, wheel = self._window, self._p.wheel
        n = window.count
        stiffness = np.exp(self._q[0] + self._q[1])
        slip = min(max(window.torque[0] / (wheel.radius * wheel.vertical_load * stiffness), 0.0), 0.2)
        omega = window.measured_wheel_speed[:n]
        lever = window.speed_per_wheel_speed
        guess = omega[0] * (wheel.radius / (1.0 - slip) + lever) + window.impulse[0]
        measured = window.has_speed[:n] > 0.0
        if slip > 0.01 and measured.any():
            guess = float(np.median((window.measured_speed[:n] + lever * omega + window.impulse[:n])[measured]))
        self._momentum_speed = float(guess)
        self._past.information[MOMENTUM, MOMENTUM] += _START_SPEED_STDDEV**-2
        self._past.reference[MOMENTUM] = guess

    def _follow(self, sample: Sample, torque: float) -> CurveEstimate | Refusal:
        window, p = self._window, self._p
        verdict = self._torque_watch.judge(sample.time, torque)
        suspect_before, self._suspect, torque = self._suspect, verdict.suspect, verdict.torque
        if verdict.rehabilitated:
            window.rehabilitate_newest_torques(verdict.rehabilitated[-window.count :])
            suspect_before = False
        trust = SET_ASIDE if suspect_before or self._suspect else 1.0
        prediction = predict(
            window, self._q, self._momentum_speed, self._covariance, p.wheel, p.noise, sample.time, torque, trust
        )
        if prediction.speed < p.gate.min_speed:
            return Refusal(Reason.LOW_SPEED, f"vehicle speed {prediction.speed:.2f} m/s is too low")
        if window.count == window.capacity:
            self._fold_oldest(window.capacity // 3)
        window.append(
            sample.time, sample.wheel_speed, sample.vehicle_speed, torque, max(prediction.wheel_speed, 0.0)
        )
        self._samples += 1
        self._set_aside(trust, (sample.wheel_speed - prediction.wheel_speed) / prediction.stddev)
        if self._monitor.changed:
            self._begin_on_new_surface()
        else:
            self._iterate(at_most=3)
        nothing_new = self._nothing_new()
        if nothing_new:
            self._summarise()
            return Refusal(Reason.NO_EXCITATION, nothing_new)
        return self._publish()

    def _set_aside(self, equation_trust: float, innovation: float) -> None:
        """Set aside what should not bend the curve: a surprising wheel speed, the equations of a suspect torque.

        After a run of surprises too long for outliers the wheel speed counts again, and how the wheel came there not.
        A curve of few samples may be wrong itself: it judges nothing.
        """
        window = self._window
        newest = window.count - 1
        surprising = self._is_settled and equation_trust == 1.0 and self._monitor.take(innovation)
        if self._monitor.run > LONGEST_OUTLIER:
            equation_trust = SET_ASIDE
            window.wheel_speed[newest] = window.measured_wheel_speed[newest]
        elif surprising:
            window.wheel_speed_trust[newest] = SET_ASIDE
        window.equation_trust[newest] = equation_trust

    def _fold_oldest(self, number: int) -> None:
        window, p = self._window, self._p
        x = np.array([*self._q, self._momentum_speed, window.wheel_speed[number]])
        past = fold(self._equations(oldest=number), number, x)
        duration = float(window.time[number] - window.time[0])
        self._past = past.loosened(MOMENTUM, (p.acceleration_error * duration) ** 2).aged(duration, p.memory)
        window.drop_oldest(number)

    def _begin_on_new_surface(self) -> None:
        """Forget the curve and all samples before the first surprise; the speed of the vehicle goes on."""
        window = self._window
        keep = self._monitor.since
        window.drop_oldest(window.count - keep)
        window.wheel_speed[:keep] = window.measured_wheel_speed[:keep]
        window.wheel_speed_trust[:keep] = window.equation_trust[:keep] = 1.0
        variance = float(self._covariance[MOMENTUM, MOMENTUM]) + _START_SPEED_DOUBT**2
        self._past = momentum_evidence(self._momentum_speed, variance)
        self._q = self._prior_mean.copy()
        self._samples = keep
        self._smallest_slip, self._largest_slip = 1.0, 0.0
        self._cause = RestartCause.SURFACE
        self._monitor.reset()
        self._iterate(at_most=6)

    def _nothing_new(self) -> str:
        """Why further samples would say nothing about the curve, or ""."""
        window, noise = self._window, self._p.noise
        n = window.count
        torque = window.torque[:n]
        if n >= _RELEASED and float(torque[-1]) < 4.0 * noise.torque:
            slips = window.slips(self._momentum_speed)
            if is_released(torque[-_RELEASED:], slips[-_RELEASED:], noise.torque):
                return "the brake is released"
        if n >= _QUIET and float(np.ptp(torque[-_QUIET:])) < 8.0 * noise.torque:
            slips = window.slips(self._momentum_speed)
            if float(np.ptp(slips[-_QUIET:])) < _QUIET_SLIP_SPAN:
                return "torque and slip have been constant: more of them say nothing new"
        return ""

    def _equations(self, oldest: int | None = None) -> NormalEquations:
        p = self._p
        thresholds = p.thresholds if self._is_settled else _NO_OUTLIERS
        return assemble(self._window, self._q, self._momentum_speed, p.wheel, p.noise, thresholds, self._past, oldest)

    @property
    def _is_settled(self) -> bool:
        return self._samples >= self._p.limits.min_samples

    def _posterior(self) -> tuple[NormalEquations, float]:
        """Normal equations with the prior, and the cost at the present unknowns."""
        equations = self._equations()
        offset = self._q - self._prior_mean
        gradient = self._prior_information @ offset
        equations.corner[:3, :3] += self._prior_information
        equations.corner[:3, 4] += gradient
        return equations, equations.cost + 0.5 * float(gradient @ offset)

    def _iterate(self, at_most: int) -> None:
        """Gauss-Newton steps; a long one that raises the cost is taken back by halves."""
        equations, cost = self._posterior()
        for _ in range(at_most):
            solution = solve(equations)
            longest = float(np.abs(solution.step[:3]).max())
            share = min(1.0, _LONGEST_STEP / max(longest, 1e-12))
            self._move(solution, share)
            self._covariance = solution.covariance
            if longest < _SETTLED:
                return
            equations, new_cost = self._posterior()
            for _ in range(_HALVINGS):
                if new_cost <= cost:
                    break
                share *= 0.5
                self._move(solution, -share)
                equations, new_cost = self._posterior()
            cost = new_cost

    def _move(self, solution: Solution, share: float) -> None:
        window = self._window
        window.wheel_speed[: window.count] += share * solution.wheel_speed_step
        self._momentum_speed += share * float(solution.step[MOMENTUM])
        q = self._q + share * solution.step[:3]
        self._q = np.clip(q, self._prior_mean - self._prior_reach, self._prior_mean + self._prior_reach)

    def _blind_covariance(self) -> Array:
        """Covariance of (q, u, omega), honest where all slips lie beyond the peak.

        There th2 has no effect on the data any more, and the quadratic about the fit does not see the long tail of
        steeper curves: th2 is then as uncertain as the prior says.
        """
        peak = float(self._q[1] - self._q[2]) / float(np.exp(self._q[1]))
        if self._smallest_slip <= peak:
            return self._covariance
        blind = np.zeros((5, 5))
        blind[1, 1] = self._p.prior.theta_2_log_stddev**2
        return np.asarray(self._covariance + blind)

    def _publish(self) -> CurveEstimate:
        newest = self._window.newest_slip(self._momentum_speed)
        self._smallest_slip = min(self._smallest_slip, newest.slip)
        self._largest_slip = max(self._largest_slip, newest.slip)
        cause, self._cause = self._cause, RestartCause.NONE
        span = (self._smallest_slip, self._largest_slip)
        return describe(self._q, self._blind_covariance(), newest, self._samples, span, self._p.limits, cause)
