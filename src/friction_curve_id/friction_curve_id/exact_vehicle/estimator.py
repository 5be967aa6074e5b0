"""Method `exact_vehicle`: when samples enter the full-information fit, which are set aside, when the fit restarts.

Samples wait until the brake moves (`excitation`); then every sample updates the fit (`map_fit`). Surprising wheel
speeds and suspect torques are set aside (`torque_watch`), many surprises mean a new road (`surface_change`).
"""

from dataclasses import dataclass, field, replace
from math import isfinite, nan

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.curve.validity import ValidityLimits
from friction_curve_id.exact_vehicle.braking_window import SET_ASIDE
from friction_curve_id.exact_vehicle.curve_uncertainty import describe
from friction_curve_id.exact_vehicle.excitation import is_driven, is_excited, is_released, wheel_trend
from friction_curve_id.exact_vehicle.map_fit import FitParameters, MapFit
from friction_curve_id.exact_vehicle.surface_change import LONGEST_OUTLIER, SurfaceChangeMonitor
from friction_curve_id.exact_vehicle.torque_watch import TorqueWatch
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause, Sample
from friction_curve_id.sample_gate import GateParameters, SampleGate
from friction_curve_id.stamp_order import Admission
from sensor_monitor.signal_noise import SignalNoise
from vehicle_models import burckhardt_log
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

_LEAD_IN = 20
"""Samples kept while waiting for the brake or the wheel to move."""
_SHORT_LEAD_IN = 3
"""The same where the engine moves the wheel, whose torque is not known."""
_QUIET = 40
"""Samples of constant torque and slip after which more of them add no information."""
_RELEASED = 10
"""Samples without brake torque and slip that end the braking."""
_QUIET_SLIP_SPAN = 0.002
_STANDING = 5.0
"""Wheel speed, in standard deviations of its noise, up to which a wheel may stand: its brake then holds with less than
its torque."""
_STABLE = 0.6
"""Slip over lambda_max that is surely on the stable side: nearer the peak a curve is flat, and friction there within
what its level on either side may be wrong by."""
_MOST_TORQUE = 1.2
"""Torque of a brake over the one measured, at most."""
_NOISIER = 2.0
"""Times the stated variance of a wheel speed from which on the one that is seen counts in its place."""


@dataclass(frozen=True)
class ExactVehicleParameters(FitParameters):
    """Noise and prior of the estimator, and its limits for samples and valid estimates."""

    gate: GateParameters = field(default_factory=GateParameters)
    limits: ValidityLimits = ValidityLimits(min_samples=20)


class ExactVehicleEstimator:
    """CurveEstimator of one wheel."""

    def __init__(self, wheel: CornerParameters, parameters: ExactVehicleParameters = ExactVehicleParameters()) -> None:
        """Start from the prior."""
        self._radius, self._inertia = wheel.radius, wheel.inertia
        self._p = parameters
        self._gate = SampleGate(wheel.radius, parameters.gate)
        self._fit = MapFit(wheel, parameters)
        stated = parameters.noise.wheel_speed_variance
        self._rolling = SignalNoise(stated, stated)
        self._monitor = SurfaceChangeMonitor()
        self._torque_watch = TorqueWatch(parameters.noise.torque)
        self._cause = RestartCause.NONE
        self._forget()

    def reset(self) -> None:
        """Forget everything; the next estimate reports a restart on request."""
        self._gate.reset()
        self._forget()
        self._cause = RestartCause.REQUEST

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample; never raises on bad data."""
        admission = self._gate.admit(sample)
        stands = self._stands(sample)
        if isinstance(admission, Refusal):
            if stands and admission.reason is Reason.LOW_SPEED:
                self._gate.pass_over(sample.time)
                self._stood_at = sample.time
            return admission
        if stands:
            self._stood_at = sample.time
            return Refusal(Reason.LOW_SPEED, f"wheel speed {sample.wheel_speed:.3g} rad/s: the wheel may stand")
        assert sample.brake_torque is not None
        try:
            return self._take(sample, sample.brake_torque, admission)
        except np.linalg.LinAlgError as error:
            self._forget()
            return Refusal(Reason.BAD_INPUT, f"the fit failed and starts again: {error}")

    def _forget(self) -> None:
        self._fit.forget()
        self._monitor.reset()
        self._torque_watch.reset()
        self._suspect = False
        self._stood_at = nan
        self._fitting = False
        self._count(0)

    def _count(self, samples: int) -> None:
        """Restart the count of samples at `samples`."""
        self._samples = samples
        self._smallest_slip, self._largest_slip = 1.0, 0.0
        self._beyond = False

    def _take(self, sample: Sample, torque: float, admission: Admission) -> CurveEstimate | Refusal:
        window = self._fit.window
        since = sample.time - window.time[window.count - 1] if window.count else 0.0
        gap = admission is Admission.AFTER_GAP or since > self._p.gate.max_gap
        if gap and not sample.time - self._stood_at <= self._p.gate.max_gap:
            self._pause(sample.time)
        if self._fitting:
            return self._follow(sample, torque)
        return self._wait(sample, torque)

    def _pause(self, time: float) -> None:
        """Restart the dead reckoning after a gap; the evidence on the curve fades with the length of the gap."""
        if self._fitting:
            self._stop()
        if self._samples:
            self._cause = RestartCause.GAP
        self._fit.lose_speed(time)
        self._torque_watch.reset()
        self._suspect = False
        self._stood_at = nan
        self._samples = 0

    def _stands(self, sample: Sample) -> bool:
        """Whether the wheel may stand. A speed of zero that no brake could have brought about is garbage."""
        window, last = self._fit.window, self._fit.window.count - 1
        noise = _STANDING * self._fit.noise.wheel_speed
        if not self._fitting or not abs(sample.wheel_speed) <= noise:
            return False
        stood = isfinite(self._stood_at)
        since = sample.time - (self._stood_at if stood else float(window.time[last]))
        if not 0.0 < since <= self._p.gate.max_gap:
            return False
        loss = _MOST_TORQUE * float(window.torque[last]) / self._inertia * since
        return stood or float(window.measured_wheel_speed[last]) <= loss + noise

    def _stop(self) -> None:
        self._fit.summarise()
        self._monitor.reset()
        self._fitting = False

    def _wait(self, sample: Sample, torque: float) -> CurveEstimate | Refusal:
        window = self._fit.window
        self._rolling.update(round(sample.time * NANOSECONDS), sample.wheel_speed)
        if sample.vehicle_speed is None and sample.wheel_speed * self._radius < self._p.gate.minimum_speed:
            return Refusal(Reason.LOW_SPEED, f"wheel speed {sample.wheel_speed:.3g} rad/s is low, no speed is measured")
        window.append(sample.time, sample.wheel_speed, sample.vehicle_speed, torque, sample.wheel_speed)
        if window.count > _LEAD_IN:
            window.drop_oldest(1)
        n = window.count
        noise, seen = self._p.noise, self._rolling.variance
        if seen > _NOISIER * noise.wheel_speed_variance:
            noise = replace(noise, wheel_speed_variance=seen)
        self._fit.noise = noise
        trend = wheel_trend(window.time[:n], window.measured_wheel_speed[:n], noise.wheel_speed)
        if not is_excited(trend, window.torque[:n], noise.wheel_speed, noise.torque):
            if is_driven(trend, window.torque[:n], noise.torque):
                window.drop_oldest(n - _SHORT_LEAD_IN)
            return Refusal(Reason.NO_EXCITATION, "torque and slip are constant: the curve cannot be seen")
        self._start()
        return self._publish()

    def _start(self) -> None:
        """Begin to fit the waiting samples."""
        if not self._fit.start():
            if self._samples:
                self._cause = RestartCause.GAP
            self._count(0)
        self._samples += self._fit.window.count
        self._fitting = True
        self._iterate(at_most=6)

    def _iterate(self, at_most: int) -> None:
        self._fit.robust = self._is_settled
        self._fit.iterate(at_most)

    def _follow(self, sample: Sample, torque: float) -> CurveEstimate | Refusal:
        window = self._fit.window
        if isfinite(self._stood_at):
            self._fit.go_on_after_standing(sample.time, torque)
            self._torque_watch.reset()
            self._monitor.reset()
            self._suspect, self._stood_at = True, nan
        verdict = self._torque_watch.judge(sample.time, torque)
        suspect_before, self._suspect, torque = self._suspect, verdict.suspect, verdict.torque
        if verdict.rehabilitated:
            window.rehabilitate_newest_torques(verdict.rehabilitated[-window.count :])
            suspect_before = False
        trust = SET_ASIDE if suspect_before or self._suspect else 1.0
        prediction = self._fit.predict(sample.time, torque, trust)
        if prediction.speed < self._p.gate.minimum_speed:
            return Refusal(Reason.LOW_SPEED, f"vehicle speed {prediction.speed:.2f} m/s is too low")
        self._fit.make_room()
        window.append(sample.time, sample.wheel_speed, sample.vehicle_speed, torque, max(prediction.wheel_speed, 0.0))
        self._samples += 1
        self._set_aside(trust, (sample.wheel_speed - prediction.wheel_speed) / prediction.stddev)
        if self._monitor.changed:
            self._begin_on_new_surface()
        else:
            self._iterate(at_most=3)
        nothing_new = self._nothing_new()
        if nothing_new:
            self._stop()
            return Refusal(Reason.NO_EXCITATION, nothing_new)
        return self._publish()

    def _begin_on_new_surface(self) -> None:
        newest = self._monitor.since
        self._monitor.reset()
        self._fit.begin_on_new_surface(newest)
        self._count(newest)
        self._cause = RestartCause.SURFACE
        self._iterate(at_most=6)

    def _set_aside(self, equation_trust: float, innovation: float) -> None:
        """Set aside what should not bend the curve: a surprising wheel speed, the equations of a suspect torque.

        After a run of surprises too long for outliers the measured wheel speed counts again, but not the wheel equation
        that leads to it. A curve of few samples may itself be wrong, so nothing is set aside on its account.
        """
        window = self._fit.window
        newest = window.count - 1
        surprising = self._is_settled and equation_trust == 1.0 and self._monitor.take(innovation)
        if self._monitor.run > LONGEST_OUTLIER:
            equation_trust = SET_ASIDE
            window.wheel_speed[newest] = window.measured_wheel_speed[newest]
        elif surprising:
            window.wheel_speed_trust[newest] = SET_ASIDE
        window.equation_trust[newest] = equation_trust

    def _nothing_new(self) -> str:
        """Return why further samples would add no information on the curve, or ""."""
        window, noise = self._fit.window, self._fit.noise
        n = window.count
        torque = window.torque[:n]
        if n >= _RELEASED and float(torque[-1]) < 4.0 * noise.torque:
            slips = window.slips(self._fit.momentum_speed)
            if is_released(torque[-_RELEASED:], slips[-_RELEASED:], noise.torque):
                return "the brake is released"
        if n >= _QUIET and float(np.ptp(torque[-_QUIET:])) < 8.0 * noise.torque:
            slips = window.slips(self._fit.momentum_speed)
            if float(np.ptp(slips[-_QUIET:])) < _QUIET_SLIP_SPAN:
                return "torque and slip have been constant: more of them say nothing new"
        return ""

    @property
    def _is_settled(self) -> bool:
        return self._samples >= self._p.limits.min_samples

    def _blind_covariance(self, lambda_max: float) -> Array:
        """Covariance of (q, u, omega), honest where all slips lie beyond the peak, `lambda_max`.

        There th2 has no effect on the data any more, and the quadratic about the fit misses the long tail of steeper
        curves: th2 is then as uncertain as in the prior.
        """
        if self._smallest_slip <= lambda_max:
            return self._fit.covariance
        blind = np.zeros((5, 5))
        blind[1, 1] = self._p.prior.theta_2_log_stddev**2
        return np.asarray(self._fit.covariance + blind)

    def _publish(self) -> CurveEstimate:
        newest = self._fit.window.newest_slip(self._fit.momentum_speed)
        lambda_max = burckhardt_log.lambda_max(self._fit.q)
        self._smallest_slip = min(self._smallest_slip, newest.slip)
        self._largest_slip = max(self._largest_slip, newest.slip)
        self._beyond = self._beyond or self._smallest_slip >= lambda_max
        if self._beyond and newest.slip < _STABLE * lambda_max:
            # From here on it is to be passed as by any rise.
            self._beyond, self._largest_slip = False, newest.slip
        cause, self._cause = self._cause, RestartCause.NONE
        span = (self._smallest_slip, self._largest_slip)
        covariance = self._blind_covariance(lambda_max)
        return describe(self._fit.q, covariance, newest, self._samples, span, self._beyond, self._p.limits, cause)
