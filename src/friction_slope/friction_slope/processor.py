"""wheel_states, <wheel>/brake_pressure and <wheel>/slip in, <wheel>/friction_slope out: one processor a wheel."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import FrictionSlope, WheelSlip
from sensor_msgs.msg import FluidPressure, JointState

from friction_runtime.aligner import AlignedInput, AlignedSample, Aligner
from friction_runtime.brake_torque import BrakeTorque
from friction_runtime.new_message import new_message
from friction_runtime.processor import Health, Level, Output, Report, silent
from friction_runtime.stamps import from_nanoseconds, header_at, to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import METHODS, Reason, SlopeEstimate, SlopeSample
from friction_slope.parameters import FrictionSlopeParameters
from vehicle_models.vehicle import Vehicle

_SILENT_AFTER = 0.25
"""[s]"""
_QUIET = (Reason.OK, Reason.NOT_READY, Reason.LOW_SPEED, Reason.NOT_BRAKING, Reason.NO_EXCITATION)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_TORQUE, Reason.NO_SLIP)
"""Reasons that no wait cures."""
_UNKNOWN_SLIP = (nan, nan, 0.0, nan, 0.0)
"""Slip, slip rate, are they valid, vehicle speed, is it known."""


class WheelProcessor:
    """Layer 2 of friction_slope. Fires for each wheel_states sample, once the other inputs have reached its stamp."""

    def __init__(
        self, wheel: str, vehicle: Vehicle, parameters: FrictionSlopeParameters, report: Report = silent
    ) -> None:
        """Build for one wheel of a car; `report` takes what a person should know."""
        self._wheel = wheel
        self._report = report
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._pressure, self._slip = self._brake_torque.topic, f"{wheel}/slip"
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self._pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {self._slip: WheelSlip} if parameters.takes_slip else {}
        self.outputs: Mapping[str, type] = {f"{wheel}/friction_slope": FrictionSlope}
        inputs = [AlignedInput(topic, parameters.detector.max_gap) for topic in (self._pressure, *self.estimates)]
        self._aligner: Aligner[float] = Aligner(WHEEL_STATES, inputs, parameters.deadline)
        self._wheel_speeds = WheelSpeeds(vehicle, (wheel,), report)
        method = METHODS[parameters.method]
        self._method = int(method)
        self._detector = SlopeDetector(vehicle.corner(wheel), method, parameters.detector, parameters.no_slip)
        self.reset()

    def reset(self) -> None:
        """Start anew, as after construction."""
        self._aligner.reset()
        self._detector.reset()
        self._last: SlopeEstimate | None = None
        self._slip_reason = ""
        self._silent = ""

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message, return what follows from it."""
        stamp = to_nanoseconds(message.header.stamp)
        if topic == WHEEL_STATES:
            self._silent = ""
            (speed,) = self._wheel_speeds.read(message)
            refusal = self._aligner.offer_primary(stamp, speed)
        elif topic == self._pressure:
            refusal = self._offer_pressure(message)
        else:
            refusal = self._offer_slip(stamp, message)
        if refusal is not None:
            self._report("warning", f"{refusal}: sample refused")
        return list(map(self._fire, self._aligner.ready()))

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Note silence of wheel_states for diagnostics: without a sample there is no stamp to speak of."""
        age = ages.get(WHEEL_STATES, 0.0)
        self._silent = f"{WHEEL_STATES}: no message for {age:.2f} s" if age > _SILENT_AFTER else ""
        return []

    def health(self) -> Health:
        """State for diagnostics."""
        last = self._last
        if self._silent or last is None:
            return Health(self._wheel, Level.ERROR, self._silent or f"{WHEEL_STATES}: no sample yet")
        values = {
            "sign": str(last.sign),
            "H [rad/s^3]": f"{last.h:.1f}",
            "indicator [rad/s^3]": f"{last.indicator:.1f}",
            "crossings": str(last.crossings),
            "slip at the last crossing": f"{last.slip_at_crossing:.4f}",
        }
        level = Level.OK if last.reason in _QUIET else Level.ERROR if last.reason in _BROKEN else Level.WARN
        return Health(self._wheel, level, last.reason_text or "ok", values)

    def _offer_pressure(self, message: FluidPressure) -> str | None:
        read = self._brake_torque.read(message)
        if isinstance(read, str):
            return read
        stamp, torque = read
        return self._aligner.offer(self._pressure, stamp, (torque,))

    def _offer_slip(self, stamp: int, message: WheelSlip) -> str | None:
        # What is not known travels as a flag, so that an interpolation between a known and an unknown slip is unknown.
        slip, slip_rate, valid = message.slip, message.slip_rate, 1.0
        if not (message.valid and isfinite(slip) and isfinite(slip_rate)):
            slip, slip_rate, valid = 0.0, 0.0, 0.0
            self._slip_reason = message.reason_text
        speed, known = message.vehicle_speed, 1.0
        if not isfinite(speed):
            speed, known = 0.0, 0.0
        return self._aligner.offer(self._slip, stamp, (slip, slip_rate, valid, speed, known))

    def _fire(self, sample: AlignedSample[float]) -> Output:
        if sample.rewound:
            self._detector.reset()
            self._report("info", f"{WHEEL_STATES}: stamps jumped back, started anew")
        torque = sample.values.get(self._pressure)
        slip, slip_rate, valid, speed, known = sample.values.get(self._slip, _UNKNOWN_SLIP)
        estimate = self._detector.update(
            SlopeSample(
                stamp=sample.stamp,
                wheel_speed=sample.payload,
                brake_torque=nan if torque is None else torque[0],
                slip=slip if valid == 1.0 else nan,
                slip_rate=slip_rate if valid == 1.0 else nan,
                vehicle_speed=speed if known == 1.0 else nan,
            )
        )
        self._last = estimate
        return f"{self._wheel}/friction_slope", self._message(sample, estimate)

    def _message(self, sample: AlignedSample[float], estimate: SlopeEstimate) -> FrictionSlope:
        text = estimate.reason_text
        if estimate.reason is Reason.NO_TORQUE:
            text = sample.missing.get(self._pressure, text)
        elif estimate.reason is Reason.NO_SLIP:
            text = sample.missing.get(self._slip, f"{self._slip}: {self._slip_reason or text}")
        message = new_message(FrictionSlope)
        message.header = header_at(sample.stamp, self._wheel)
        message.wheel = self._wheel
        message.method = self._method
        message.sign = estimate.sign
        message.h = estimate.h
        message.indicator = estimate.indicator
        message.delay = estimate.delay
        message.crossings = estimate.crossings
        message.crossing_sign = estimate.crossing_sign
        message.slip_at_crossing = estimate.slip_at_crossing
        message.crossing_stamp = from_nanoseconds(estimate.crossing_stamp)
        message.valid = estimate.reason is Reason.OK
        message.reason = int(estimate.reason)
        message.reason_text = text and f"{self._wheel}: {text}"
        return message


def build(parameters: FrictionSlopeParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one a wheel."""
    return [WheelProcessor(wheel, vehicle, parameters, report) for wheel in vehicle.wheel_names]
