"""Sign of the slope of the friction curve of one wheel, methods slip (8.4) and no_slip (8.5)."""

from dataclasses import dataclass
from math import isfinite, isnan, nan

from friction_slope.crossing import CrossingDetector
from friction_slope.estimate import Method, Reason, SlopeEstimate, SlopeSample
from friction_slope.indicator import eta_sign, normalised_deceleration, slip_rate_sign
from friction_slope.reference_speed import ReferenceSpeed
from friction_slope.signals import SignalWindow

_NANOSECONDS = 1_000_000_000
LOCKED_SLIP = 0.8
"""Beyond the peak of any road [-]. A wheel that stands does so by constraint: (8.3) does not hold for it."""
HIGHEST_FRICTION = 1.5
"""Of any road [-]."""
JITTER = 2.0
"""Of a wheel speed that is no spike [rad/s]."""
_SIGNED = (Reason.OK, Reason.NO_EXCITATION)
"""Reasons with which a sign is told."""
LOCKED_INDICATOR = -1e5
"""Indicator of a locked wheel [rad/s^3], below every threshold."""


@dataclass(frozen=True)
class DetectorParameters:
    """Of one wheel; config/friction_slope.yaml says what each is."""

    method: Method
    radius: float
    """r [m]"""
    inertia: float
    """J [kg m^2]"""
    vertical_load: float
    """Fz [N]"""
    window: int
    """samples for H"""
    rate_window: int
    """samples for slip rate and eta"""
    lead: float
    """where H is read, see signals.SignalWindow"""
    h_instability: float
    """[rad/s^3], <= 0"""
    h_stability: float
    """[rad/s^3], >= 0"""
    slip_rate_dead_zone: float
    """[1/s]"""
    eta_margin: float
    """[-]"""
    minimum_torque: float
    """[N m] below it the wheel is not braked ..."""
    braking_hold: float
    """... but for this long [s]: it may still be on its way back"""
    minimum_speed: float
    """[m/s]"""
    max_deceleration: float
    """[m/s^2] of the reference speed"""
    max_gap: float
    """[s] between samples"""


class SlopeDetector:
    """One wheel. `update` takes all that is known at one stamp."""

    def __init__(self, parameters: DetectorParameters) -> None:
        """Build from the parameters.

        Raises:
            ValueError: thresholds or windows make no sense.
        """
        self._p = p = parameters
        self._signals = SignalWindow(p.inertia, p.window, p.rate_window, p.lead)
        self._reference = ReferenceSpeed(p.radius, p.max_deceleration)
        self._crossing = CrossingDetector(p.h_instability, p.h_stability)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._crossing.reset()
        self._last: SlopeSample | None = None
        self._braked: int | None = None
        self._reference.reset()
        self._forget_samples()
        self._had_gap = False

    def update(self, sample: SlopeSample) -> SlopeEstimate:
        """Take a sample and estimate at its stamp. A sample that is refused leaves the state as it was."""
        if not isfinite(sample.wheel_speed):
            return self._estimate(Reason.BAD_INPUT, "wheel speed is missing or not finite")
        if not isfinite(sample.brake_torque):
            return self._estimate(Reason.NO_TORQUE, "no brake torque")
        if self._last is not None:
            gap = (sample.stamp - self._last.stamp) / _NANOSECONDS
            if gap <= 0.0:
                return self._estimate(Reason.BAD_INPUT, "stamp does not advance")
            possible = self._possible_jump(sample, self._last, gap)
            if gap > self._p.max_gap:
                self._forget_samples()
                self._had_gap = True
                # A wheel that turns belies a reference speed it cannot have come from; one that stands may be locked.
                if not possible and sample.wheel_speed * self._p.radius > self._p.minimum_speed:
                    self._reference.reset()
            elif not possible:
                return self._estimate(Reason.BAD_INPUT, f"wheel speed jumps to {sample.wheel_speed:.1f} rad/s")
        self._last = sample
        self._signals.update(sample)
        self._reference.update(sample)
        if sample.brake_torque >= self._p.minimum_torque:
            self._braked = sample.stamp
        if not self._signals.ready:
            if self._had_gap:
                return self._estimate(Reason.GAP, f"gap of more than {self._p.max_gap} s, filling the window anew")
            return self._estimate(Reason.NOT_READY, "filling the window")
        self._had_gap = False
        return self._judge(sample)

    def _judge(self, sample: SlopeSample) -> SlopeEstimate:
        p, signals = self._p, self._signals
        speed = self._reference.speed
        if p.method is Method.SLIP and isfinite(sample.vehicle_speed):
            speed = sample.vehicle_speed
        if speed < p.minimum_speed:
            return self._unknown(Reason.LOW_SPEED, f"speed is below {p.minimum_speed} m/s")
        h, delay = signals.h(), signals.delay
        if self._braked is None or sample.stamp - self._braked > p.braking_hold * _NANOSECONDS:
            return self._unknown(Reason.NOT_BRAKING, f"brake torque is below {p.minimum_torque} N m", h, delay)
        slip_rate = signals.slip_rate() if p.method is Method.SLIP else 0.0
        if isnan(slip_rate):
            return self._unknown(Reason.NO_SLIP, "slip was not valid throughout the window", h, delay)
        read_at = sample.stamp - round(delay * _NANOSECONDS)
        if sample.wheel_speed * p.radius < (1.0 - LOCKED_SLIP) * speed:
            self._crossing.update(LOCKED_INDICATOR, 1, signals.slip, read_at)
            return self._estimate(Reason.OK, "", nan, delay, LOCKED_INDICATOR)
        growing = self._growing(slip_rate)
        indicator = h * growing
        self._crossing.update(indicator, growing, signals.slip, read_at)
        if growing == 0:
            rate = "slip rate" if p.method is Method.SLIP else "eta"
            return self._estimate(Reason.NO_EXCITATION, f"{rate} in its dead zone, sign is held", h, delay, indicator)
        if self._crossing.sign == 0:
            return self._estimate(Reason.NOT_READY, "indicator has not passed a threshold yet", h, delay, indicator)
        return self._estimate(Reason.OK, "", h, delay, indicator)

    def _growing(self, slip_rate: float) -> int:
        """Sign of the slip rate by the method, 0 in the dead zone; `slip_rate` [1/s] is what the method slip reads."""
        p = self._p
        if p.method is Method.SLIP:
            return slip_rate_sign(slip_rate, p.slip_rate_dead_zone)
        friction = self._signals.friction_moment() / (p.radius * p.vertical_load)
        eta = normalised_deceleration(self._signals.wheel_acceleration(), p.radius)
        return eta_sign(eta, friction, p.eta_margin, p.slip_rate_dead_zone, self._reference.speed)

    def _possible_jump(self, sample: SlopeSample, last: SlopeSample, gap: float) -> bool:
        """Can brake and road have turned the wheel to this speed? A spike must not raise the reference speed."""
        p = self._p
        torque = max(abs(sample.brake_torque), abs(last.brake_torque)) + HIGHEST_FRICTION * p.radius * p.vertical_load
        return abs(sample.wheel_speed - last.wheel_speed) <= gap * torque / p.inertia + JITTER

    def _forget_samples(self) -> None:
        self._signals.reset()
        self._crossing.forget_sign()
        self._braked = None

    def _unknown(self, reason: Reason, text: str, h: float = nan, delay: float = nan) -> SlopeEstimate:
        self._crossing.forget_sign()
        return self._estimate(reason, text, h, delay)

    def _estimate(
        self, reason: Reason, text: str, h: float = nan, delay: float = nan, indicator: float = nan
    ) -> SlopeEstimate:
        crossing = self._crossing
        return SlopeEstimate(
            sign=crossing.sign if reason in _SIGNED else 0,
            h=h,
            indicator=indicator,
            delay=delay,
            crossings=crossing.crossings,
            crossing_sign=crossing.crossing_sign,
            slip_at_crossing=crossing.slip,
            crossing_stamp=crossing.stamp,
            reason=reason,
            reason_text=text,
        )
