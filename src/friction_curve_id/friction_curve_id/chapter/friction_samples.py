"""Samples of the friction curve, mu(slip), from the signals of one wheel: (8.8) and two better conditioned forms.

Each takes two neighbouring samples and holds at the middle between them: rates are differences over the
interval, levels are means. The difference and the mean of white noise are uncorrelated, so that the noise of
omega does not enter mu and slip together. At 200 Hz with the noise of section 8.3.2 (sigma of omega 0.07 rad/s,
v 0.5 m/s, T_b 3.2 N m) on the corner of that section:

- SLIP_EQUATION: (8.8) as printed, with the measured speed. Passes on the noise of v twice: in the slip (sigma
  0.012 at 30 m/s) and differenced in slip_dot, which puts a sigma near 0.7 on mu; the two are correlated
  through slip(t).
- WHEEL_EQUATION: mu = (J omega_dot + T_b) / (r Fz), from (2.15) alone, against the slip from the measured
  speed. mu does not depend on v: sigma 0.03, nearly all from omega (each difference shares its omega with the
  next, so that it averages out as 1/N and not as 1/sqrt(N)). The slip keeps its 0.012: errors in variables
  flatten and bias the fit.
- DEAD_RECKONED: the same mu against the slip from the dead-reckoned speed (dead_reckoning.py): sigma of the slip
  0.0005, and an error of the anchor (0.02 m/s, 0.0007 of slip) common to all samples. The best of the three.

All three scale mu with 1/Fz, which leaves lambda_max where it is.
"""

from enum import Enum
from math import isfinite
from typing import Final, NamedTuple

from friction_curve_id.chapter.dead_reckoning import FREE_ROLLING_TORQUE, DeadReckonedSpeed
from friction_curve_id.interface import Refusal, Sample
from friction_curve_id.measurement_noise import MeasurementNoise
from friction_curve_id.sample_gate import GateParameters, SampleGate
from friction_curve_id.stamp_order import Admission
from vehicle_models.physical_bounds import HIGHEST_TORQUE, HIGHEST_WHEEL_SPEED
from vehicle_models.reason import Reason
from vehicle_models.vehicle import CornerParameters

_GATE, _NOISE = GateParameters(), MeasurementNoise()
LARGEST_FRICTION: Final = 10.0
"""|mu| above this is no friction, whatever the noise: racing tyres reach 2, (8.8) with noisy v scatters by 2."""


class FrictionSource(Enum):
    """How friction samples are made."""

    SLIP_EQUATION = "slip_equation"
    WHEEL_EQUATION = "wheel_equation"
    DEAD_RECKONED = "dead_reckoned"


class FrictionPoint(NamedTuple):
    """One sample of the friction curve."""

    time: float
    """Stamp of the newer of the two samples it is made of [s]."""
    slip: float
    """[-], inside (-1, 1)."""
    mu: float
    """[-]"""
    braking: bool = True
    """Whether the brake is applied."""
    after_gap: bool = False
    """Whether this is the first point after a gap or a jump back in time, where fits start again."""


class _Known:
    def __init__(self, time: float, wheel_speed: float, speed: float, torque: float) -> None:
        self.time = time
        self.wheel_speed = wheel_speed
        self.speed = speed
        self.torque = torque


class FrictionSamples:
    """Makes a `FrictionPoint` of each sample and the one before."""

    def __init__(
        self,
        wheel: CornerParameters,
        source: FrictionSource = FrictionSource.DEAD_RECKONED,
        gate: GateParameters = _GATE,
        noise: MeasurementNoise = _NOISE,
    ) -> None:
        """Choose the form; `gate` sets which samples are admitted, `noise` how far dead reckoning trusts each."""
        self._wheel = wheel
        self._source = source
        self._is_dead_reckoned = source is FrictionSource.DEAD_RECKONED
        self._gate_parameters = gate
        self._gate = SampleGate(wheel.radius, gate)
        self._reckoned = DeadReckonedSpeed(wheel, noise)
        self.reset()

    def reset(self) -> None:
        """Forget the samples seen."""
        self._gate.reset()
        self._reckoned.reset()
        self._last: _Known | None = None
        self._interrupted = False

    def update(self, sample: Sample) -> FrictionPoint | Refusal:
        """Return the point between the last sample and this one, or why there is none."""
        if sample.wheel_speed > HIGHEST_WHEEL_SPEED:
            return Refusal(Reason.BAD_INPUT, f"{sample.wheel_speed:.3g} rad/s is not a wheel speed")
        if abs(sample.brake_torque or 0.0) > HIGHEST_TORQUE:
            return Refusal(Reason.BAD_INPUT, f"{sample.brake_torque:.3g} N m is not a brake torque")
        admission = self._gate.admit(sample)
        if isinstance(admission, Refusal):
            return admission
        assert sample.brake_torque is not None
        if not self._is_dead_reckoned and sample.vehicle_speed is None:
            return Refusal(Reason.NO_SLIP, f"vehicle speed is missing, '{self._source.value}' needs it")
        last = self._last
        if last is not None:
            gap = sample.time - last.time > self._gate_parameters.max_gap
            if admission is Admission.AFTER_GAP or gap:
                self._interrupted = True
                last = None
        if last is None:
            return self._begin(sample, sample.brake_torque)
        return self._continue(last, sample, sample.brake_torque)

    def _begin(self, sample: Sample, torque: float) -> Refusal:
        if self._is_dead_reckoned:
            speed = self._reckoned.start(sample.wheel_speed, sample.vehicle_speed, torque)
        else:
            assert sample.vehicle_speed is not None
            speed = sample.vehicle_speed
        if isinstance(speed, Refusal):
            self._last = None
            return speed
        self._last = _Known(sample.time, sample.wheel_speed, speed, torque)
        return Refusal(Reason.NOT_READY, "first sample: a friction sample takes two")

    def _continue(self, last: _Known, sample: Sample, torque: float) -> FrictionPoint | Refusal:
        w, dt = self._wheel, sample.time - last.time
        change, mean_torque = sample.wheel_speed - last.wheel_speed, 0.5 * (last.torque + torque)
        friction = (w.inertia * change / dt + mean_torque) / (w.radius * w.vertical_load)
        if not abs(friction) <= LARGEST_FRICTION:
            return Refusal(Reason.BAD_INPUT, f"wheel speed and brake torque give mu = {friction:.3g}")
        if self._is_dead_reckoned:
            speed = self._reckoned.advance(dt, change, mean_torque, sample.wheel_speed, sample.vehicle_speed)
        else:
            assert sample.vehicle_speed is not None
            speed = sample.vehicle_speed
        known = _Known(sample.time, sample.wheel_speed, speed, torque)
        if speed < self._gate_parameters.minimum_speed:
            self._last, self._interrupted = None, True
            return Refusal(Reason.LOW_SPEED, f"dead-reckoned speed {speed:.2f} m/s is too low")
        slip_before, slip_now = self._slip(last), self._slip(known)
        slip = 0.5 * (slip_before + slip_now)
        if not -1.0 < slip < 1.0:
            self._last, self._interrupted = None, True
            return Refusal(Reason.NO_SLIP, f"slip {slip:.2f} is outside (-1, 1)")
        self._last = known
        if self._source is FrictionSource.SLIP_EQUATION:
            wheel_speed = 0.5 * (last.wheel_speed + sample.wheel_speed)
            friction = slip_equation(w, slip, (slip_now - slip_before) / dt, wheel_speed, mean_torque)
            if not (isfinite(friction) and abs(friction) <= LARGEST_FRICTION):
                return Refusal(Reason.BAD_INPUT, f"(8.8) gives mu = {friction:.3g}")
        after_gap, self._interrupted = self._interrupted, False
        return FrictionPoint(sample.time, slip, friction, mean_torque > FREE_ROLLING_TORQUE, after_gap)

    def _slip(self, known: _Known) -> float:
        return 1.0 - known.wheel_speed * self._wheel.radius / known.speed


def slip_equation(
    wheel: CornerParameters, slip: float, slip_rate: float, wheel_speed: float, brake_torque: float
) -> float:
    """Friction coefficient of (8.8) [-]: the single-corner dynamics (8.7) solved for mu, with v = omega r / (1 - slip).

    (8.7), which is (2.18): d slip / dt = -(1 / v) ((1 - slip) / m + r^2 / J) Fz mu(slip) + r / (v J) T_b.

    Args:
        wheel: radius, inertia, mass, vertical load.
        slip: [-].
        slip_rate: [1/s].
        wheel_speed: omega [rad/s], > 0.
        brake_torque: T_b [N m].
    """
    w, rolling = wheel, 1.0 - slip
    numerator = rolling / (w.inertia * wheel_speed) * brake_torque - slip_rate
    return numerator / (
        rolling / (wheel_speed * w.radius) * w.vertical_load * (rolling / w.mass + w.radius * w.radius / w.inertia)
    )
