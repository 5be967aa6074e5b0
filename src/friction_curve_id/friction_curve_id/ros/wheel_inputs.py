"""Inputs of the methods that use wheel speed, brake torque and vehicle speed."""

from collections.abc import Mapping
from math import nan
from typing import Any

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import FluidPressure, JointState

from friction_curve_id.interface import CurveEstimate, Refusal, Sample
from friction_curve_id.parameters import SLIP, FrictionCurveParameters
from friction_curve_id.parameters import VEHICLE_VELOCITY as SPEED_SENSOR
from friction_curve_id.ros.inputs import (
    SPEED_SENSOR_GAP,
    VEHICLE_VELOCITY,
    Reading,
    known_speed,
    vehicle_velocity,
    wheel_slip,
)
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.processor import Report
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle


class WheelInputs:
    """CurveInputs of one wheel: fires on wheel_states."""

    def __init__(self, wheel: str, vehicle: Vehicle, parameters: FrictionCurveParameters, report: Report) -> None:
        """Identify the curve of `wheel`; messages without its speed go to `report`."""
        max_gap = parameters.gate.max_gap
        self.primary = WHEEL_STATES
        self._wheel_speeds = WheelSpeeds(vehicle, (wheel,), report)
        self._estimator = parameters.estimator(vehicle, wheel)
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._pressure = self._brake_torque.topic
        self._slip = f"{wheel}/slip"
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self._pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {}
        self.aligned = [AlignedInput(self._pressure, max_gap)]
        self._speed = ""
        if parameters.speed_source == SLIP:
            self._speed = self._slip
            self.estimates = {self._slip: WheelSlip}
            self.aligned.append(AlignedInput(self._slip, max_gap))
        elif parameters.speed_source == SPEED_SENSOR:
            self._speed = VEHICLE_VELOCITY
            self.sensors = {**self.sensors, VEHICLE_VELOCITY: TwistWithCovarianceStamped}
            self.aligned.append(AlignedInput(VEHICLE_VELOCITY, SPEED_SENSOR_GAP))

    def read_primary(self, message: JointState) -> float:
        """Wheel speed [rad/s]."""
        (speed,) = self._wheel_speeds.read(message)
        return speed

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return the brake torque [N m], or the content of the speed's topic."""
        if topic == self._pressure:
            reading = self._brake_torque.read(message)
            return reading if isinstance(reading, str) else (reading[0], (reading[1],))
        return wheel_slip(message) if topic == self._slip else vehicle_velocity(message)

    def answer(self, sample: AlignedSample[float]) -> tuple[CurveEstimate | Refusal, float]:
        """Return the answer of the estimator, and the slip of <wheel>/slip."""
        values = sample.values.get(self._slip)
        slip = values[2] if values is not None and values[3] == 1.0 else nan
        torque = sample.values.get(self._pressure)
        given = nan if torque is None else torque[0]
        if wrong_unit := self._brake_torque.wrong_unit(sample.stamp, sample.payload, given):
            return Refusal(Reason.BAD_INPUT, wrong_unit), slip
        if torque is None:
            return Refusal(Reason.NO_PRESSURE, sample.missing[self._pressure]), slip
        speed = known_speed(sample, self._speed)
        return self._estimator.update(Sample(sample.time, sample.payload, speed, torque[0])), slip

    def reset(self) -> None:
        """Reset the estimator."""
        self._estimator.reset()
        self._brake_torque.reset()
