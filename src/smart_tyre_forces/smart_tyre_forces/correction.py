"""From raw fronts to length and shift free of speed and load: Omega_0, speed trends, beta.

    Delta phi = k (alpha_2 - alpha_1) - Q(v) + Delta phi_0                                            (8.13)
    delta phi = (alpha_1 + alpha_2)/2 + Omega_0 - (P(v) - P(v_0)) + beta (Delta phi - Delta phi_0)    (8.15), (8.19)

Omega_0 is found at the first stretch of constant low speed v_0 that lasts some seconds, so that delta phi is zero
there (the chapter gives 10 ms, which is less than a revolution). k is 1 until the length is re-zeroed at constant
speed, after a change of pressure.
"""

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from friction_parameters.parameter import parameter
from smart_tyre_forces.calibration import TyreCalibration, polynomial
from smart_tyre_forces.patch_tracker import Passage
from vehicle_models.reason import Reason

_TEXTS: Final = {
    Reason.OK: "",
    Reason.NOT_READY: "no zero yet: waiting for a stretch of constant low speed",
    Reason.SPEED_RANGE: "waiting for a speed within the range of the method",
    Reason.GAP: "packets lost: wheel angle unknown until the teeth are recognised again",
    Reason.SATURATED: "accelerometer saturated: use one with a wider range",
    Reason.NO_FRONTS: "waiting for both edges of the contact patch in the acceleration",
    Reason.MISSED_TOOTH: "missed tooth: wheel angle unknown until the teeth are recognised again",
    Reason.REVERSAL: "standstill or reversal: wheel angle unknown until the teeth are recognised again",
    Reason.BAD_INPUT: "signal not finite",
    Reason.NOT_CALIBRATED: "not calibrated: give calibration_file; length and shift are raw",
}
_UNSTEADY = (Reason.SPEED_RANGE, Reason.REVERSAL)
"""Reasons that end a stretch of constant speed; a revolution lost for another reason is only missing from it."""
_FEWEST = 8
"""Least revolutions in a stretch."""


@dataclass(frozen=True)
class ZeroParameters:
    """When a stretch of driving is steady enough to set a zero."""

    duration: float = parameter(4.0, "length of a stretch of constant speed", unit="s", minimum=0.5, maximum=60.0)
    speed_spread: float = parameter(
        0.03, "highest over lowest speed of such a stretch, less one", minimum=1e-3, maximum=0.2
    )
    maximum_speed: float = parameter(
        12.0,
        "highest speed of the first stretch, which sets the zero of the shift; a requested zero may be at any speed",
        unit="m/s",
        minimum=5.0,
        maximum=50.0,
    )
    pressure_tolerance: float = parameter(
        0.04,
        "change of contact patch length at constant speed that is reported as a change of pressure",
        minimum=0.005,
        maximum=0.5,
    )


@dataclass(frozen=True)
class Patch:
    """Contact patch of one revolution; angles NaN where there is none [rad]."""

    passage: Passage
    reason: Reason
    speed: float = np.nan
    """Circumferential speed omega R [m/s]."""
    alpha_1: float = np.nan
    """Angle of the leading front, with Omega_0."""
    alpha_2: float = np.nan
    length_raw: float = np.nan
    """Length Delta phi of (8.13), uncorrected."""
    shift_raw: float = np.nan
    """Shift delta phi of (8.15), with Omega_0, uncorrected."""
    length: float = np.nan
    """Length with the speed trend removed."""
    shift: float = np.nan
    """Shift with the speed trend and the part of the load removed, see load_shift."""
    length_bias: float = 0.0
    """Error of the length at the last constant speed [rad], once it is reported as a change of pressure."""

    @property
    def text(self) -> str:
        """The reason in words, empty where it is OK."""
        return _TEXTS[self.reason]


@dataclass(frozen=True)
class _Steady:
    time: float
    speed: float
    centre: float
    length_raw: float


class PatchCorrection:
    """Corrections of one wheel."""

    def __init__(
        self,
        calibration: TyreCalibration | None,
        radius: float,
        sample_rate: float,
        parameters: ZeroParameters = ZeroParameters(),
    ) -> None:
        """Start without zero; without a calibration only the raw values and the zero are available."""
        self._calibration = calibration
        self._radius, self._sample_rate = radius, sample_rate
        self._parameters = parameters
        self._stretch: deque[_Steady] = deque()
        self._reference: int | None = None
        self._omega_0: float | None = None
        self._length_wanted = False
        self._any_speed = False
        self.zero_speed = np.nan
        """Speed v_0 at which Omega_0 was found [m/s]; NaN until then."""
        self.length_scale = 1.0
        """Factor k of (8.13) [-]."""
        self._length_bias = 0.0

    @property
    def pressure_changed(self) -> bool:
        """Whether the length at the last constant speed was longer or shorter than it should be."""
        return self._length_bias != 0.0

    def request_shift_zero(self) -> None:
        """Find Omega_0 again at the next stretch of constant speed, whatever the speed."""
        self._omega_0 = None
        self._any_speed = True
        self._stretch.clear()

    def request_length_zero(self) -> None:
        """Find k again at the next stretch of constant speed: the pressure has changed."""
        self._length_wanted = True
        self._stretch.clear()

    def update(self, passage: Passage) -> Patch:
        """Correct one passage."""
        speed = passage.wheel_speed * self._radius
        if passage.reason is not Reason.OK:
            if passage.reason in _UNSTEADY:
                self._stretch.clear()
            return Patch(passage, passage.reason, speed)
        if passage.reference != self._reference:
            self._reference, self._omega_0 = passage.reference, None
            self._stretch.clear()
        centre, length_raw = passage.centre, passage.length
        self._stretch.append(_Steady(passage.time / self._sample_rate, speed, centre, length_raw))
        self._learn_from_stretch()
        if self._omega_0 is None:
            return Patch(passage, Reason.NOT_READY, speed, length_raw=length_raw)
        shift_raw = _wrapped(centre + self._omega_0)
        length, shift = self._corrected(speed, shift_raw, length_raw)
        reason = Reason.OK if self._calibration is not None else Reason.NOT_CALIBRATED
        return Patch(
            passage=passage,
            reason=Reason.NOT_READY if self._length_wanted else reason,
            speed=speed,
            alpha_1=shift_raw - 0.5 * length_raw,
            alpha_2=shift_raw + 0.5 * length_raw,
            length_raw=length_raw,
            shift_raw=shift_raw,
            length=length,
            shift=shift,
            length_bias=self._length_bias,
        )

    def _corrected(self, speed: float, shift_raw: float, length_raw: float) -> tuple[float, float]:
        c = self._calibration
        if c is None:
            return length_raw, shift_raw
        longer = self.length_scale * length_raw - polynomial(c.length_trend, speed)
        trend = polynomial(c.shift_trend, speed) - polynomial(c.shift_trend, self.zero_speed)
        return longer + c.nominal_length, shift_raw - trend + load_shift(c, longer)

    def _learn_from_stretch(self) -> None:
        stretch, p = self._stretch, self._parameters
        while len(stretch) > _FEWEST and stretch[-1].time - stretch[1].time >= p.duration:
            stretch.popleft()
        if len(stretch) < _FEWEST or stretch[-1].time - stretch[0].time < p.duration:
            return
        speeds = [entry.speed for entry in stretch]
        if max(speeds) > (1.0 + p.speed_spread) * min(speeds):
            return
        speed = float(np.mean(speeds))
        if self._calibration is not None:
            self._check_length(float(np.mean([entry.length_raw for entry in stretch])), speed)
        if self._omega_0 is None and (self._any_speed or speed <= p.maximum_speed):
            self._zero(speed)

    def _check_length(self, length_raw: float, speed: float) -> None:
        assert self._calibration is not None
        expected = polynomial(self._calibration.length_trend, speed)
        if self._length_wanted:
            self.length_scale, self._length_wanted = expected / length_raw, False
        bias = self.length_scale * length_raw - expected
        self._length_bias = bias if abs(bias) > self._parameters.pressure_tolerance * expected else 0.0

    def _zero(self, speed: float) -> None:
        """Set Omega_0 such that the corrected shift is zero on the mean of the stretch."""
        first = self._stretch[0].centre
        self.zero_speed = speed
        self._omega_0 = 0.0
        shifts = [self._corrected(e.speed, _wrapped(e.centre - first), e.length_raw)[1] for e in self._stretch]
        self._omega_0 = -first - float(np.mean(shifts))
        self._any_speed = False


def load_shift(tyre: TyreCalibration, longer: float) -> float:
    """Return the correction f_F(Fz) that removes from the shift the part due to the load, not to Fx [rad] (8.17).

    Fz is not known, so it is taken from the length, f_F(Delta phi) (8.18); a line suffices,
    beta (Delta phi - Delta phi_0) (8.19).

    Args:
        tyre: calibration of the tyre.
        longer: Delta phi - Delta phi_0 [rad], by which the patch is longer than at rest.
    """
    return tyre.beta * longer


def _wrapped(angle: float) -> float:
    """Return the angle wrapped to -pi..pi [rad]."""
    return angle - 2.0 * np.pi * round(angle / (2.0 * np.pi))
