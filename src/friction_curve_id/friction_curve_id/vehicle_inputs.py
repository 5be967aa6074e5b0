"""Inputs of the whole-vehicle method: wheel speeds, acceleration and vehicle speed."""

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu, JointState

from friction_curve_id.inputs import (
    IMU,
    SPEED_GAP,
    VEHICLE_VELOCITY,
    known_speed,
    vehicle_velocity,
    wheel_slip,
)
from friction_curve_id.interface import CurveEstimate, Reason, Refusal
from friction_curve_id.parameters import SLIP, FrictionCurveParameters
from friction_curve_id.vehicle_samples import VehicleSample
from friction_curve_id.whole_vehicle import WholeVehicle
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.processor import Report
from friction_runtime.stamps import NANOSECONDS
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds


class VehicleInputs:
    """CurveInputs of the vehicle: fires on wheel_states."""

    def __init__(self, parameters: FrictionCurveParameters, report: Report) -> None:
        """Fit one curve for all wheels; `report` is told of messages that lack the speed of one."""
        self.primary = WHEEL_STATES
        self._p = parameters
        self._wheel_speeds = WheelSpeeds(parameters.wheels, report)
        self._vehicle = WholeVehicle(parameters.vehicle())
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, IMU: Imu}
        self.estimates: Mapping[str, type] = {}
        if parameters.speed_source == SLIP:
            self._speed = f"{parameters.wheels[0]}/slip"
            self.estimates = {self._speed: WheelSlip}
        else:
            self._speed = VEHICLE_VELOCITY
            self.sensors = {**self.sensors, VEHICLE_VELOCITY: TwistWithCovarianceStamped}
        self.aligned = [AlignedInput(IMU), AlignedInput(self._speed, SPEED_GAP)]

    def read_primary(self, message: JointState) -> tuple[float, ...]:
        """Speeds of the wheels [rad/s], NaN where one is missing."""
        return self._wheel_speeds.read(message)

    def read(self, topic: str, message: Any) -> tuple[float, ...] | str:
        """Acceleration [m/s^2], or what the speed's topic holds."""
        if topic == IMU:
            value = getattr(message.linear_acceleration, self._p.imu_axis)
            return (self._p.imu_sign * value - self._p.imu_offset,)
        return vehicle_velocity(message) if topic == VEHICLE_VELOCITY else wheel_slip(message)

    def answer(self, sample: AlignedSample[tuple[float, ...]]) -> tuple[CurveEstimate | Refusal, float]:
        """Answer of the fit; the slip is the estimate's, the mean of all wheels by load."""
        if not all(isfinite(speed) for speed in sample.payload):
            named = dict(zip(self._p.wheels, sample.payload, strict=True))
            missing = ", ".join(wheel for wheel, speed in named.items() if not isfinite(speed))
            return Refusal(Reason.BAD_INPUT, f"{WHEEL_STATES}: no usable velocity for {missing}"), nan
        acceleration = sample.values.get(IMU)
        if acceleration is None:
            return Refusal(Reason.NO_ACCELERATION, sample.missing[IMU]), nan
        speed = known_speed(sample, self._speed)
        if speed is None:
            return Refusal(Reason.NO_SLIP, sample.missing.get(self._speed, f"{self._speed}: no vehicle speed")), nan
        taken = VehicleSample(sample.stamp / NANOSECONDS, speed, acceleration[0], sample.payload)
        return self._vehicle.update(taken), nan

    def reset(self) -> None:
        """Start the fit anew."""
        self._vehicle.reset()
