"""Which samples may enter a fit: finite, in order of time, moving, without a gap."""

from dataclasses import dataclass
from enum import Enum
from math import isfinite

from friction_curve_id.interface import Reason, Refusal, Sample
from friction_parameters import shared

_REPEATED = 1e-4
"""Samples closer than this count as repeated [s]."""


class Admission(Enum):
    """How an admitted sample follows the ones before it."""

    FIRST = "first"
    NEXT = "next"
    AFTER_GAP = "after a gap"


@dataclass(frozen=True)
class GateParameters:
    """Limits for samples that may enter a fit."""

    minimum_speed: float = shared.minimum_speed(3.0)
    max_gap: float = shared.max_gap(0.025)


class SampleGate:
    """Admits samples one by one.

    After a gap, or a jump back in time, the first sample is refused; the one that continues it is admitted as
    `AFTER_GAP`, so that a single wrong stamp costs one sample and never the fit.
    """

    def __init__(self, radius: float, parameters: GateParameters = GateParameters()) -> None:
        """Make a gate for a wheel of effective radius `radius` [m]."""
        self._radius = radius
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Forget the stamps seen."""
        self._admitted: float | None = None
        self._waiting: float | None = None

    def admit(self, sample: Sample) -> Admission | Refusal:
        """Return how `sample` follows the admitted ones, or why it must not enter."""
        refusal = self._refuse_values(sample)
        if refusal is not None:
            return refusal
        time, waiting, last = sample.time, self._waiting, self._admitted
        if last is None:
            self._admitted = time
            return Admission.FIRST
        if self._follows(last, time):
            self._admitted, self._waiting = time, None
            return Admission.NEXT
        if waiting is not None and self._follows(waiting, time):
            self._admitted, self._waiting = time, None
            return Admission.AFTER_GAP
        if abs(time - last) < _REPEATED:
            return Refusal(Reason.BAD_INPUT, f"stamp {time:.6f} s repeats {last:.6f} s")
        self._waiting = time
        if time < last:
            return Refusal(Reason.GAP, f"stamp {time:.6f} s is before the last, {last:.6f} s")
        return Refusal(Reason.GAP, f"gap of {time - last:.3f} s since the last sample")

    def _follows(self, before: float, time: float) -> bool:
        return _REPEATED <= time - before <= self._parameters.max_gap

    def _refuse_values(self, sample: Sample) -> Refusal | None:
        speed, torque = sample.vehicle_speed, sample.brake_torque
        if torque is None:
            return Refusal(Reason.NO_TORQUE, "brake torque is missing")
        if not (isfinite(sample.time) and isfinite(sample.wheel_speed) and isfinite(torque)):
            values = {"time": sample.time, "wheel speed": sample.wheel_speed, "brake torque": torque}
            bad = next(f"{name} is {value}" for name, value in values.items() if not isfinite(value))
            return Refusal(Reason.BAD_INPUT, bad)
        if sample.wheel_speed <= 0.0:
            return Refusal(Reason.LOW_SPEED, f"wheel speed {sample.wheel_speed:.3g} rad/s is not positive")
        if speed is None:
            return None
        if not isfinite(speed):
            return Refusal(Reason.BAD_INPUT, f"vehicle speed is {speed}")
        limit = self._parameters.minimum_speed
        if speed < limit:
            return Refusal(Reason.LOW_SPEED, f"vehicle speed {speed:.2f} m/s is below {limit:.2f} m/s")
        slip = 1.0 - sample.wheel_speed * self._radius / speed
        if not -1.0 < slip < 1.0:
            return Refusal(Reason.NO_SLIP, f"slip {slip:.2f} is outside (-1, 1)")
        return None
