"""wheel_states, pressure, slip and imu/data in, estimate or vote out: a processor for either at each wheel."""

from collections.abc import Mapping
from math import nan
from typing import Any, Final

from friction_msgs.msg import FrictionSlope, SlopeVote, WheelSlip
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.aligned_processor import AlignedProcessor
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.brake_torque import BrakeTorque
from friction_runtime.new_message import new_message
from friction_runtime.primary import Primary
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.reason_text import of_wheel, set_reason
from friction_runtime.slip_fault import slip_fault, slip_is_known, speed_is_known
from friction_runtime.stamps import from_nanoseconds, header_at, to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import METHODS, Method, Reason, SlopeEstimate, SlopeSample
from friction_slope.parameters import FrictionSlopeParameters
from vehicle_models.plausible import HIGHEST_ACCELERATION
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_load import WheelLoad

_IMU: Final = "imu/data"
_QUIET = (
    *(Reason.OK, Reason.NOT_READY, Reason.LOW_SPEED, Reason.NOT_BRAKING),
    *(Reason.NO_EXCITATION, Reason.NOT_LASTING),
)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_TORQUE,)
"""Reasons that do not go away by waiting."""
_UNKNOWN_SLIP = (nan, nan, 0.0, nan, 0.0)
"""Slip, slip rate, 1 if they are valid, vehicle speed, 1 if it is known."""


class WheelProcessor(AlignedProcessor[float]):
    """Layer 2 of friction_slope: fires on wheel_states."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        parameters: FrictionSlopeParameters,
        report: Report = silent,
        votes: bool = False,
    ) -> None:
        """Build for one wheel of a car.

        Args:
            wheel: its name.
            vehicle: the car.
            parameters: of the node.
            report: the log function.
            votes: publish <wheel>/slope_vote in place of <wheel>/friction_slope.
        """
        self._wheel, self._votes = wheel, votes
        self._topic = f"{wheel}/slope_vote" if votes else f"{wheel}/friction_slope"
        method, detector, no_slip = METHODS[parameters.method], parameters.detector, parameters.no_slip
        if votes:
            vote = parameters.vote
            method, detector, no_slip = Method.NO_SLIP, vote.detector(detector), vote.no_slip
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._pressure, self._slip = self._brake_torque.topic, f"{wheel}/slip"
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self._pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {self._slip: WheelSlip} if parameters.takes_slip else {}
        self.outputs: Mapping[str, type] = {self._topic: SlopeVote if votes else FrictionSlope}
        max_gap = detector.max_gap
        inputs = [AlignedInput(topic, max_gap) for topic in (self._pressure, *self.estimates)]
        load = WheelLoad(vehicle, wheel) if detector.load_transfer else None
        if load is not None and load.transfer == 0.0:
            load = None  # one axle only: the acceleration moves no load, and is not waited for
        if load is not None:
            self.sensors = {**self.sensors, _IMU: Imu}
            inputs.append(AlignedInput(_IMU, max_gap, optional=True))
        name = f"{wheel} vote" if votes else wheel
        super().__init__(name, Primary(WHEEL_STATES, name, report), inputs, parameters.deadline, optional=(_IMU,))
        self._accelerometer = vehicle.accelerometer
        self._wheel_speeds = WheelSpeeds(vehicle, (wheel,), report)
        self._detector = SlopeDetector(
            vehicle.corner(wheel),
            method,
            detector,
            no_slip,
            load,
            vehicle.wheel(wheel).relaxation_length,
        )
        self._forget()

    def _payload(self, message: JointState) -> float:
        (speed,) = self._wheel_speeds.read(message)
        return speed

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == _IMU:
            return self._offer_acceleration(message)
        return self._offer_pressure(message) if topic == self._pressure else self._offer_slip(message)

    def _forget(self) -> None:
        self._detector.reset()
        self._brake_torque.reset()
        self._last: SlopeEstimate | None = None
        self._text = ""
        self._slip_fault = ""

    def _start_again(self, stamp: int) -> None:
        self._detector.reset()

    def _state(self) -> tuple[Level, str]:
        level = Level.OK if self._last is None else level_of(self._last.reason, _QUIET, _BROKEN)
        if not self._slip_fault:
            return level, self._text
        return max(level, Level.WARN), f"{self._text}; {self._slip_fault}" if self._text else self._slip_fault

    def _values(self) -> dict[str, str]:
        last = self._last
        if last is None:
            return {}
        return {
            "sign": str(last.sign),
            "H [rad/s^3]": f"{last.h:.1f}",
            "indicator [rad/s^3]": f"{last.indicator:.1f}",
            "method": last.method.name.lower(),
            "vertical load": "from imu/data" if last.load_transfer else "at rest",
            "crossings": str(last.crossings),
            "slip at the last crossing": f"{last.slip_at_crossing:.4f}",
        }

    def _offer_pressure(self, message: FluidPressure) -> str | None:
        read = self._brake_torque.read(message)
        if isinstance(read, str):
            return read
        stamp, torque = read
        return self._aligner.offer(self._pressure, stamp, (torque,))

    def _offer_acceleration(self, message: Imu) -> str | None:
        acceleration = self._accelerometer.forward(message.linear_acceleration)
        if not abs(acceleration) <= HIGHEST_ACCELERATION:
            return f"{_IMU}: {acceleration} m/s^2 is not an acceleration of a car"
        return self._aligner.offer(_IMU, to_nanoseconds(message.header.stamp), (acceleration,))

    def _offer_slip(self, message: WheelSlip) -> str | None:
        # Validity travels as a number, so that an interpolation between a known and an unknown slip is unknown.
        slip, slip_rate, valid = message.slip, message.slip_rate, 1.0
        if not slip_is_known(message):
            slip, slip_rate, valid = 0.0, 0.0, 0.0
        self._slip_fault = slip_fault(self._slip, message)
        speed, known = message.vehicle_speed, 1.0
        if not speed_is_known(message):
            speed, known = 0.0, 0.0
        stamp = to_nanoseconds(message.header.stamp)
        return self._aligner.offer(self._slip, stamp, (slip, slip_rate, valid, speed, known))

    def _fire(self, sample: AlignedSample[float]) -> list[Output]:
        torque = sample.values.get(self._pressure)
        slip, slip_rate, valid, speed, known = sample.values.get(self._slip, _UNKNOWN_SLIP)
        acceleration = sample.values.get(_IMU, (nan,))
        brake_torque = nan if torque is None else torque[0]
        estimate = self._detector.update(
            SlopeSample(
                stamp=sample.stamp,
                wheel_speed=sample.payload,
                brake_torque=brake_torque,
                slip=slip if valid == 1.0 else nan,
                slip_rate=slip_rate if valid == 1.0 else nan,
                vehicle_speed=speed if known == 1.0 else nan,
                acceleration=acceleration[0],
            )
        )
        wrong_unit = self._brake_torque.wrong_unit(sample.stamp, sample.payload, brake_torque)
        if wrong_unit:
            estimate.reason, estimate.text = Reason.BAD_INPUT, wrong_unit
        self._last = estimate
        self._text = self._reason(sample, estimate)
        message = self._vote(sample.stamp, estimate) if self._votes else self._message(sample.stamp, estimate)
        return [(self._topic, message)]

    def _reason(self, sample: AlignedSample[float], estimate: SlopeEstimate) -> str:
        """Return the reason of an estimate in words; for a missing input, why it is missing."""
        text = estimate.text
        if estimate.reason is Reason.NO_TORQUE:
            return sample.missing.get(self._pressure, text)
        return text

    def _message(self, stamp: int, estimate: SlopeEstimate) -> FrictionSlope:
        message = self._told(FrictionSlope, stamp, estimate)
        message.method = int(estimate.method)
        message.sign = estimate.sign
        message.crossings = estimate.crossings
        message.crossing_sign = estimate.crossing_sign
        message.slip_at_crossing = estimate.slip_at_crossing
        message.crossing_stamp = from_nanoseconds(estimate.crossing_stamp)
        set_reason(message, self._wheel, estimate.reason, self._text)
        return message

    def _vote(self, stamp: int, estimate: SlopeEstimate) -> SlopeVote:
        message = self._told(SlopeVote, stamp, estimate)
        message.reason = int(estimate.reason)
        message.reason_text = of_wheel(self._wheel, self._text)
        return message

    def _told(self, kind: type, stamp: int, estimate: SlopeEstimate) -> Any:
        """Return a message with what estimate and vote have in common."""
        message = new_message(kind)
        message.header = header_at(stamp, self._wheel)
        message.wheel = self._wheel
        message.h = estimate.h
        message.indicator = estimate.indicator
        message.delay = estimate.delay
        return message


def build(parameters: FrictionSlopeParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: for each wheel its vote, served first, and its estimate, which reports for both."""
    wheels = vehicle.wheel_names
    votes = [WheelProcessor(wheel, vehicle, parameters, silent, votes=True) for wheel in wheels]
    return votes + [WheelProcessor(wheel, vehicle, parameters, report) for wheel in wheels]
