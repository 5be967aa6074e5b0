"""Sign of the slope of the friction curve of one wheel, methods slip (8.4) and no_slip (8.5).

Where the slip is lost, the method slip answers by (8.5), which needs wheel speed and brake torque only. H is the same,
and its window is full; the sign is known again when an indicator of the other equation has passed a threshold.
"""

from dataclasses import dataclass
from math import isfinite, isnan, nan
from typing import Final

from friction_parameters.parameter import max_gap_parameter, minimum_speed_parameter, parameter
from friction_slope.crossing import CrossingDetector, ToldSlips
from friction_slope.estimate import Method, SlopeEstimate, SlopeSample
from friction_slope.indicator import Doubt, eta_sign, normalised_deceleration, slip_rate_sign, slope_indicator
from friction_slope.signals import SignalWindow
from friction_slope.tyre_relaxation import TyreRelaxation
from vehicle_models.constants import GRAVITY
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ROAD_FRICTION, SlowestCar
from vehicle_models.reason import Reason
from vehicle_models.vehicle import CornerParameters
from vehicle_models.wheel_forces import WheelLoad

LOCKED_SLIP: Final = 0.8
"""Beyond the peak of any road [-]. A wheel that stands does so by constraint: (8.3) does not hold for it."""
LOCKED_TYRE_SLIP: Final = 0.6
"""Slip that the tyre of such a wheel must have built up [-]: above any peak, twice the relaxation length included."""
CERTAINTY: Final = 3.0
"""Deviations by which H must be above 0 for a wheel to be surely on the stable side."""
FAR: Final = 0.5
"""Share of its slip by which a wheel may have come nearer to the peak since a sign was told."""
LEAST_FAR: Final = 0.03
"""The same for small slips [-]."""
LEAST_PEAK: Final = 0.02
"""Slip below which no road has its peak [-]."""
LEAST_SCATTER: Final = 0.05
"""Scatter of the best wheel speeds [rad/s]."""
JITTER: Final = 2.0
"""Largest jitter of a wheel speed that is not a spike [rad/s]."""
SAME_TIME: Final = 1e-6
"""Times closer than this are one [s]."""
_SIGNED = (Reason.OK, Reason.NO_EXCITATION, Reason.NOT_LASTING)
"""Reasons with which a sign is published."""
NO_RELAXATION: Final = 1e-9
"""Relaxation length of a tyre whose friction follows the slip at once [m]."""
LOCKED_INDICATOR: Final = -1e5
"""Indicator of a locked wheel [rad/s^3], below every threshold."""


@dataclass(frozen=True)
class DetectorParameters:
    """Windows, thresholds and dead zones, for both methods."""

    window: int = parameter(26, "samples of the fit that gives H", minimum=3, maximum=400)
    lead: float = parameter(0.0, "where H is read: 0 window's centre, 1 newest sample", minimum=0.0, maximum=1.0)
    rate_window: int = parameter(26, "samples of the fits that give slip rate and eta", minimum=2, maximum=400)
    h_instability: float = parameter(
        -10.0, "indicator at or below which stability is lost", unit="rad/s^3", minimum=-1e5, maximum=0.0
    )
    h_stability: float = parameter(
        100.0, "indicator at or above which stability is regained", unit="rad/s^3", minimum=0.0, maximum=1e5
    )
    slip_rate_dead_zone: float = parameter(
        0.18, "slip rates up to this have no measurable sign", unit="1/s", minimum=0.0, maximum=100.0
    )
    minimum_torque: float = parameter(
        30.0, "a wheel below this brake torque for 'braking_hold' is not braked", unit="N m", minimum=0.1, maximum=1e4
    )
    braking_hold: float = parameter(
        0.3, "time for which a released wheel still counts as braked", unit="s", minimum=0.0, maximum=10.0
    )
    minimum_speed: float = minimum_speed_parameter(1.5)
    max_deceleration: float = parameter(
        12.0,
        "hardest braking of any car: bounds an unknown vehicle speed, to distinguish a locked wheel from standstill",
        unit="m/s^2",
        minimum=1.0,
        maximum=50.0,
    )
    load_transfer: bool = parameter(True, "compensate H for load transfer, from imu/data; otherwise (8.3) as printed")
    least_growth: float = parameter(
        18.0,
        "minimum growth of the slip over 'window' for a sign beyond the peak [noise of the wheel speed]",
        minimum=0.0,
        maximum=1000.0,
    )
    max_gap: float = max_gap_parameter(0.03)

    def __post_init__(self) -> None:
        """Refuse a window too short for its polynomial."""
        if self.lead > 0.0 and self.window < 4:
            raise ValueError(f"'window' = {self.window} must be at least 4 with a 'lead' ({self.lead})")


@dataclass(frozen=True)
class NoSlipParameters:
    """Parameters of (8.5): the method no_slip, and the method slip where the slip is lost."""

    slip_at_crossing: bool = parameter(
        True, "wait for <wheel>/slip too, to publish the slip at a crossing (method slip always does)"
    )
    eta_margin: float = parameter(
        0.03,
        "margin of eta above the deceleration of the car, and below 0, for a sign",
        minimum=0.0,
        maximum=100.0,
    )


class SlopeDetector:
    """Slope detector of one wheel. `update` takes all that is known at one stamp."""

    def __init__(
        self,
        corner: CornerParameters,
        method: Method,
        parameters: DetectorParameters,
        no_slip: NoSlipParameters = NoSlipParameters(),
        load: WheelLoad | None = None,
        relaxation_length: float = NO_RELAXATION,
        doubt: Doubt | None = None,
    ) -> None:
        """Build for a wheel.

        Args:
            corner: radius, inertia and vertical load of the wheel.
            method: where the sign of the slip rate comes from.
            parameters: parameters of both methods.
            no_slip: parameters of (8.5).
            load: its vertical load, from the acceleration; None, as where there is no acceleration: at rest, and (8.3)
                as printed.
            relaxation_length: of its tyre [m], > 0.
            doubt: of H, above which a sign must be to count; None for a vote, which is not sure anyway.
        """
        self._method = method
        self._doubt = doubt
        self._told = ToldSlips()
        self._load = load
        self._relaxation = TyreRelaxation(relaxation_length)
        self._p = p = parameters
        self._eta_margin = no_slip.eta_margin
        self._low_speed = f"speed is below {p.minimum_speed} m/s"
        self._not_braking = f"brake torque is below {p.minimum_torque} N m"
        self._radius, self._inertia, self._vertical_load = corner.radius, corner.inertia, corner.vertical_load
        self._signals = SignalWindow(corner.inertia, p.window, p.rate_window, p.lead)
        self._reference = SlowestCar(p.max_deceleration)
        self._crossing = CrossingDetector(p.h_instability, p.h_stability)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._crossing.reset()
        self._last: SlopeSample | None = None
        self._braked: int | None = None
        self._by = self._method
        self._reference.reset()
        self._forget_samples()
        self._had_gap = False

    def update(self, sample: SlopeSample) -> SlopeEstimate:
        """Take a sample and estimate at its stamp. A sample that is refused leaves the state as it was."""
        if not isfinite(sample.wheel_speed):
            return self._estimate(Reason.BAD_INPUT, "wheel speed is missing or not finite")
        if not isfinite(sample.brake_torque):
            return self._estimate(Reason.NO_PRESSURE, "no brake torque")
        if self._last is not None:
            gap = (sample.stamp - self._last.stamp) / NANOSECONDS
            if gap <= 0.0:
                return self._estimate(Reason.BAD_INPUT, "stamp does not advance")
            possible = self._possible_jump(sample, self._last, gap)
            if gap > self._p.max_gap:
                self._forget_samples()
                self._had_gap = True
                # A turning wheel contradicts a reference speed it cannot have come from; one that stands may be locked.
                if not possible and sample.wheel_speed * self._radius > self._p.minimum_speed:
                    self._reference.reset()
            elif not possible:
                return self._estimate(Reason.BAD_INPUT, f"wheel speed jumps to {sample.wheel_speed:.1f} rad/s")
        self._last = sample
        self._built_up = self._relaxation.update(sample.stamp, sample.slip, sample.vehicle_speed)
        self._signals.update(sample, self._built_up, self._load_at(sample))
        self._reference.update(sample.stamp, sample.wheel_speed * self._radius)
        if sample.brake_torque >= self._p.minimum_torque:
            self._braked = sample.stamp
        if not self._signals.ready:
            if self._had_gap:
                return self._estimate(Reason.GAP, f"gap of more than {self._p.max_gap} s, filling the window again")
            return self._estimate(Reason.NOT_READY, "filling the window")
        self._had_gap = False
        return self._judge(sample)

    def _judge(self, sample: SlopeSample) -> SlopeEstimate:
        p, signals = self._p, self._signals
        slip_rate = signals.slip_rate() if self._method is Method.SLIP else nan
        self._answer_by(Method.NO_SLIP if isnan(slip_rate) else Method.SLIP)
        speed = self._reference.speed
        if isfinite(sample.vehicle_speed):
            # The reference runs down while a wheel stays locked, which on ice it does for seconds.
            speed = sample.vehicle_speed if self._method is Method.SLIP else max(speed, sample.vehicle_speed)
        if speed < p.minimum_speed:
            return self._unknown(Reason.LOW_SPEED, self._low_speed)
        h, delay = signals.h(), signals.delay
        h_of_load = signals.h_of_load()
        self._load_taken = not isnan(h_of_load)
        if self._load_taken:
            h -= h_of_load
        if self._braked is None or sample.stamp - self._braked > p.braking_hold * NANOSECONDS:
            return self._unknown(Reason.NOT_BRAKING, self._not_braking, h, delay)
        read_at = sample.stamp - round(delay * NANOSECONDS)
        if sample.wheel_speed * self._radius < (1.0 - LOCKED_SLIP) * speed:
            self._crossing.update(LOCKED_INDICATOR, 1, signals.slip, read_at)
            # by the slip at the stamp, not by H
            if self._doubt is not None and self._built_up < LOCKED_TYRE_SLIP:
                return self._estimate(Reason.NOT_LASTING, "tyre has not built its slip up", nan, 0.0, LOCKED_INDICATOR)
            return self._estimate(Reason.OK, "", nan, 0.0, LOCKED_INDICATOR)
        growing, growth = self._growing(slip_rate, speed)
        swings = growing > 0 and h <= p.h_instability and not self._may_be_beyond(growth)
        if swings:
            growing = 0
        indicator = slope_indicator(h, growing)
        trial = 0 if self._doubt is None else round((delay - SAME_TIME) * NANOSECONDS)
        self._crossing.update(indicator, growing, signals.slip, read_at, trial)
        if growing == 0:
            rate = "slip rate" if self._by is Method.SLIP else "eta"
            why = "slip may only swing" if swings else f"{rate} in its dead zone"
            reason, text = Reason.NO_EXCITATION, f"{why}, sign is held"
        elif self._crossing.sign == 0:
            reason, text = Reason.NOT_READY, "indicator has not passed a threshold yet"
        elif (read_at - self._crossing.since) / NANOSECONDS < delay - SAME_TIME:
            reason, text = Reason.NOT_LASTING, "sign is younger than its delay"
        else:
            text = self._open_question(growth / speed)
            reason = Reason.NOT_LASTING if text else Reason.OK
        if self._doubt is not None:
            sign, slip = self._crossing.sign, signals.slip()
            if reason is Reason.OK:
                self._told.tell(sign, slip, read_at)
            elif self._told.cover(sign, slip, read_at):
                reason, text = Reason.OK, ""
        return self._estimate(reason, text, h, delay, indicator)

    def _answer_by(self, method: Method) -> None:
        """Choose the equation; a sign that another one has told is not held."""
        if method is not self._by:
            self._by = method
            self._crossing.forget_sign()

    def _growing(self, slip_rate: float, speed: float) -> tuple[int, float]:
        """Return the sign of the slip rate, 0 in the dead zone, and how fast the wheel falls behind the car [rad/s^2].

        Only (8.4) uses `slip_rate` [1/s] and the `speed` of the car [m/s].
        """
        p = self._p
        if self._by is Method.SLIP:
            return slip_rate_sign(slip_rate, p.slip_rate_dead_zone), slip_rate * speed / self._radius
        return self._growing_by_eta(self._signals.wheel_acceleration(), self._signals.friction_moment())

    def _growing_by_eta(self, wheel_acceleration: float, friction_moment: float) -> tuple[int, float]:
        braking = -self._signals.acceleration() / GRAVITY
        if isnan(braking):
            braking = friction_moment / (self._radius * self._vertical_load)
        eta = normalised_deceleration(wheel_acceleration, self._radius)
        sign = eta_sign(eta, braking, self._eta_margin, self._p.slip_rate_dead_zone, self._reference.speed)
        return sign, (eta - braking) * GRAVITY / self._radius

    def _open_question(self, growth: float) -> str:
        """Return why a sign that has lasted is not sure all the same; empty where it is, and of a vote.

        Slip that is not known grows by `growth` [rad/s^2 / (m/s)].
        """
        if self._doubt is None:
            return ""
        if self._crossing.sign > 0 and not self._surely_stable(self._doubt):
            return "stable side is not sure up to the time of h"
        return "slip has come much nearer to the peak" if self._has_come_near(growth) else ""

    def _surely_stable(self, doubt: Doubt) -> bool:
        """Whether the samples before the time for which h holds tell the stable side by themselves.

        Those after it may be of another part of a cycle: a release from beyond the peak looks as the rise before it.
        """
        signals = self._signals
        if self._by is Method.SLIP:
            growing = slip_rate_sign(signals.earlier_slip_rate(), 0.0)
        else:
            moment = signals.earlier_friction_moment()
            growing, _ = self._growing_by_eta(signals.earlier_wheel_acceleration(), moment)
        stddev = doubt.of_h(signals.torque_rate(), signals.torque_jerk())
        return slope_indicator(signals.earlier_h(self._load_taken), growing) > CERTAINTY * stddev

    def _has_come_near(self, growth: float) -> bool:
        """Whether slip has since moved by much towards the peak and may have passed it: H is mostly of the time before.

        Where it is not known, it grows by `growth` [rad/s^2 / (m/s)], and from nothing.
        """
        signals = self._signals
        before = signals.earlier_slip()
        change = signals.slip() - before
        if isnan(change):
            before, change = 0.0, 0.25 * growth * self._radius * signals.span
        return change * self._crossing.sign > max(FAR * before, LEAST_FAR)

    def _may_be_beyond(self, growth: float) -> bool:
        """Whether slip that grows by `growth` [rad/s^2] of wheel speed may be running away, and not only swing."""
        least, signals = self._p.least_growth, self._signals
        if least == 0.0:
            return True
        if self._by is Method.SLIP and signals.slip() < LEAST_PEAK:
            return False
        return growth * signals.span > least * max(signals.scatter(), LEAST_SCATTER)

    def _load_at(self, sample: SlopeSample) -> float:
        """Return the vertical load [N], NaN where there is no acceleration to tell it."""
        if self._load is None:
            return nan
        if isnan(sample.acceleration):
            self._load.reset()
            return nan
        # Tyres push a car no harder than this; what is more shakes the sensor and not the load.
        hardest = HIGHEST_ROAD_FRICTION * GRAVITY
        self._load.update(sample.stamp, min(max(sample.acceleration, -hardest), hardest))
        return self._load.load

    def _possible_jump(self, sample: SlopeSample, last: SlopeSample, gap: float) -> bool:
        """Whether brake and road can have caused this wheel speed: a spike must not raise the reference speed."""
        braking = max(abs(sample.brake_torque), abs(last.brake_torque))
        torque = braking + HIGHEST_ROAD_FRICTION * self._radius * self._vertical_load
        return abs(sample.wheel_speed - last.wheel_speed) <= gap * torque / self._inertia + JITTER

    def _forget_samples(self) -> None:
        self._signals.reset()
        self._relaxation.reset()
        self._load_taken = False
        self._built_up = nan
        self._told.reset()
        if self._load is not None:
            self._load.reset()
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
            method=self._by,
            load_transfer=self._load_taken,
            reason=reason,
            text=text,
        )
