"""wheel_states, pressure, slip and imu/data in, vote and estimate out: each wheel's samples are read once for both."""

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any, Final

from friction_msgs.msg import FrictionSlope, SlopeVote, WheelSlip
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample, Aligner
from friction_runtime.messages import slip_fault, slip_is_known, speed_is_known, to_nanoseconds
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from friction_slope.detector import SlopeDetector
from friction_slope.estimate import Method, SlopeEstimate, SlopeSample
from friction_slope.indicator import doubt_of
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.car_processor import CarProcessor
from friction_slope.ros.messages import estimate_message, vote_message
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.wheel_forces import WheelLoad

_IMU: Final = "imu/data"
_QUIET = (
    *(Reason.OK, Reason.NOT_READY, Reason.LOW_SPEED, Reason.NOT_BRAKING),
    *(Reason.NO_EXCITATION, Reason.NOT_LASTING),
)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_PRESSURE,)
"""Reasons that do not go away by waiting."""
_UNKNOWN_SLIP = (nan, nan, 0.0, nan, 0.0)
"""Slip, slip rate, 1 if they are valid, vehicle speed, 1 if it is known."""


class _Sample:
    """A sample of the wheel as both detectors take it, but for the acceleration."""

    def __init__(self, sample: SlopeSample, no_torque: str, wrong_unit: str) -> None:
        self.sample = sample
        self.no_torque = no_torque
        """Why there is no torque, empty where there is one."""
        self.wrong_unit = wrong_unit
        """Which unit the pressure seems to have in place of Pa, with its topic; empty where none."""

    def judged(self, detector: SlopeDetector) -> SlopeEstimate:
        estimate = detector.update(self.sample)
        if self.wrong_unit:
            estimate.reason, estimate.text = Reason.BAD_INPUT, self.wrong_unit
        elif estimate.reason is Reason.NO_PRESSURE and self.no_torque:
            estimate.text = self.no_torque
        return estimate


class WheelProcessor(AlignedProcessor[float]):
    """Layer 2 of friction_slope: fires on wheel_states, first the vote, then the estimate."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        parameters: FrictionSlopeParameters,
        report: Report = silent,
        estimates: bool = True,
    ) -> None:
        """Build for one wheel of a car.

        Args:
            wheel: its name.
            vehicle: the car.
            parameters: of the node.
            report: the log function.
            estimates: publish <wheel>/friction_slope beside <wheel>/slope_vote.
        """
        self._wheel = wheel
        corner, length = vehicle.corner(wheel), vehicle.wheel(wheel).relaxation_length
        detector, vote = parameters.detector, parameters.vote
        load = WheelLoad(vehicle, wheel) if estimates and detector.load_transfer else None
        if load is not None and load.transfer == 0.0:
            load = None  # one axle only: the acceleration moves no load, and is not waited for
        self._vote = SlopeDetector(
            corner, Method.NO_SLIP, vote.detector(detector), vote.no_slip, relaxation_length=length
        )
        self._estimate: SlopeDetector | None = None
        if estimates:
            method = Method(parameters.method)
            doubt = doubt_of(vehicle, wheel)
            self._estimate = SlopeDetector(corner, method, detector, parameters.no_slip, load, length, doubt)
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._pressure, self._slip = self._brake_torque.topic, f"{wheel}/slip"
        self._vote_topic, self._estimate_topic = f"{wheel}/slope_vote", f"{wheel}/friction_slope"
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self._pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {self._slip: WheelSlip} if parameters.takes_slip else {}
        self.outputs: Mapping[str, type] = {self._vote_topic: SlopeVote}
        if estimates:
            self.outputs = {**self.outputs, self._estimate_topic: FrictionSlope}
        inputs = [AlignedInput(topic, detector.max_gap) for topic in (self._pressure, *self.estimates)]
        accelerations: list[AlignedInput] = []
        if load is not None:
            self.sensors = {**self.sensors, _IMU: Imu}
            accelerations.append(AlignedInput(_IMU, detector.max_gap, optional=True))
        # The acceleration is waited for in a second step, as the vote does without.
        self._whole: Aligner[_Sample] = Aligner(WHEEL_STATES, accelerations, parameters.deadline)
        super().__init__(wheel, Primary(WHEEL_STATES, wheel, report), inputs, parameters.deadline, optional=(_IMU,))
        self._accelerometer = vehicle.accelerometer
        self._wheel_speeds = WheelSpeeds(vehicle, (wheel,), report)
        self._forget()

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message; return the resulting outputs."""
        outputs = [*super().process(topic, message)]
        outputs += [(self._estimate_topic, self._estimated(whole)) for whole in self._whole.ready()]
        return outputs

    def _payload(self, message: JointState) -> float:
        (speed,) = self._wheel_speeds.read(message)
        return speed

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == _IMU:
            return self._offer_acceleration(message)
        return self._offer_pressure(message) if topic == self._pressure else self._offer_slip(message)

    def _forget(self) -> None:
        self._vote.reset()
        if self._estimate is not None:
            self._estimate.reset()
        self._whole.reset()
        self._brake_torque.reset()
        self._last_vote: SlopeEstimate | None = None
        self._last: SlopeEstimate | None = None
        self._slip_fault = ""

    def _start_again(self, stamp: int) -> None:
        self._vote.reset()  # the estimate follows with its own sample of that stamp

    def _state(self) -> tuple[Level, str]:
        last = self._last or self._last_vote
        level, text = (Level.OK, "") if last is None else (level_of(last.reason, _QUIET, _BROKEN), last.text)
        if not self._slip_fault:
            return level, text
        return max(level, Level.WARN), f"{text}; {self._slip_fault}" if text else self._slip_fault

    def _values(self) -> dict[str, str]:
        values: dict[str, str] = {}
        if (last := self._last) is not None:
            values = {
                "sign": str(last.sign),
                "H [rad/s^3]": f"{last.h:.1f}",
                "indicator [rad/s^3]": f"{last.indicator:.1f}",
                "method": last.method.value,
                "vertical load": "from imu/data" if last.load_transfer else "at rest",
                "crossings": str(last.crossings),
                "slip at the last crossing": f"{last.slip_at_crossing:.4f}",
            }
        if self._last_vote is not None:
            values["vote"] = self._last_vote.text or f"{self._last_vote.indicator:.1f} rad/s^3"
        return values | {f"{topic} late samples": str(count) for topic, count in self._whole.late().items()}

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
        return self._whole.offer(_IMU, to_nanoseconds(message.header.stamp), (acceleration,))

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
        read = self._read(sample)
        self._last_vote = vote = read.judged(self._vote)
        if self._estimate is not None:
            self._whole.offer_primary(sample.stamp, read)
        return [(self._vote_topic, vote_message(self._wheel, sample.stamp, vote))]

    def _read(self, sample: AlignedSample[float]) -> _Sample:
        """Return what is known at the stamp but for the acceleration."""
        torque = sample.values.get(self._pressure)
        slip, slip_rate, valid, speed, known = sample.values.get(self._slip, _UNKNOWN_SLIP)
        brake_torque = nan if torque is None else torque[0]
        return _Sample(
            SlopeSample(
                stamp=sample.stamp,
                wheel_speed=sample.payload,
                brake_torque=brake_torque,
                slip=slip if valid == 1.0 else nan,
                slip_rate=slip_rate if valid == 1.0 else nan,
                vehicle_speed=speed if known == 1.0 else nan,
            ),
            sample.missing.get(self._pressure, ""),
            self._brake_torque.wrong_unit(sample.stamp, sample.payload, brake_torque),
        )

    def _estimated(self, whole: AlignedSample[_Sample]) -> FrictionSlope:
        """Return the estimate at a stamp, with the acceleration where there is one."""
        assert self._estimate is not None
        if whole.rewound:
            self._estimate.reset()
        read = whole.payload
        (read.sample.acceleration,) = whole.values.get(_IMU, (nan,))
        self._last = estimate = read.judged(self._estimate)
        return estimate_message(self._wheel, whole.stamp, estimate)


def build(
    parameters: FrictionSlopeParameters, vehicle: Vehicle, report: Report = silent
) -> list[WheelProcessor | CarProcessor]:
    """Make the processors: one for each wheel, and one for the car with the method slip_position."""
    by_car = Method(parameters.method) is Method.SLIP_POSITION
    wheels = [WheelProcessor(wheel, vehicle, parameters, report, not by_car) for wheel in vehicle.wheel_names]
    return [*wheels, CarProcessor(vehicle, parameters, report)] if by_car else [*wheels]
