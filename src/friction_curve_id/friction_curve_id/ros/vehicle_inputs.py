"""Inputs of the whole-vehicle method: wheel speeds, acceleration and vehicle speed."""

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import Imu, JointState

from friction_curve_id.interface import CurveEstimate, Refusal
from friction_curve_id.parameters import SLIP, FrictionCurveParameters
from friction_curve_id.ros.inputs import (
    IMU,
    SPEED_SENSOR_GAP,
    VEHICLE_VELOCITY,
    Reading,
    known_speed,
    vehicle_velocity,
    wheel_slip,
)
from friction_curve_id.vehicle.vehicle_samples import VehicleSample
from friction_curve_id.vehicle.whole_vehicle import WholeVehicle
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Report
from friction_runtime.wheel_inputs import WHEEL_STATES, WheelSpeeds
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle


class VehicleInputs:
    """CurveInputs of the vehicle, triggered by wheel_states."""

    def __init__(self, vehicle: Vehicle, parameters: FrictionCurveParameters, report: Report) -> None:
        """Fit one curve for all wheels; messages that lack the speed of a wheel go to `report`."""
        self.primary = WHEEL_STATES
        self._car = vehicle
        self._wheel_speeds = WheelSpeeds(vehicle, vehicle.wheel_names, report)
        self._fit = WholeVehicle(vehicle, parameters.vehicle)
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, IMU: Imu}
        self.estimates: Mapping[str, type] = {}
        max_gap = speed_gap = parameters.vehicle.max_gap
        if parameters.speed_source == SLIP:
            self._speed = f"{vehicle.wheel_names[0]}/slip"
            self.estimates = {self._speed: WheelSlip}
        else:
            self._speed, speed_gap = VEHICLE_VELOCITY, SPEED_SENSOR_GAP
            self.sensors = {**self.sensors, VEHICLE_VELOCITY: TwistWithCovarianceStamped}
        self.aligned = [AlignedInput(IMU, max_gap), AlignedInput(self._speed, speed_gap)]

    def read_primary(self, message: JointState) -> tuple[float, ...]:
        """Speeds of the wheels [rad/s], NaN where one is missing."""
        return self._wheel_speeds.read(message)

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return the acceleration [m/s^2], or the content of the speed's topic."""
        if topic == IMU:
            acceleration = self._car.accelerometer.forward(message.linear_acceleration)
            return to_nanoseconds(message.header.stamp), (acceleration,)
        return vehicle_velocity(message) if topic == VEHICLE_VELOCITY else wheel_slip(message)

    def answer(self, sample: AlignedSample[tuple[float, ...]]) -> tuple[CurveEstimate | Refusal, float]:
        """Return the answer of the fit and NaN: the slip is in the estimate, the load-weighted mean of all wheels."""
        if not all(isfinite(speed) for speed in sample.payload):
            named = dict(zip(self._car.wheel_names, sample.payload, strict=True))
            missing = ", ".join(wheel for wheel, speed in named.items() if not isfinite(speed))
            return Refusal(Reason.BAD_INPUT, f"{WHEEL_STATES}: no usable velocity for {missing}"), nan
        acceleration = sample.values.get(IMU)
        if acceleration is None:
            return Refusal(Reason.NO_ACCELERATION, sample.missing[IMU]), nan
        speed = known_speed(sample, self._speed)
        if speed is None:
            return Refusal(Reason.NO_SLIP, sample.missing.get(self._speed, f"{self._speed}: no vehicle speed")), nan
        taken = VehicleSample(sample.time, speed, acceleration[0], sample.payload)
        return self._fit.update(taken), nan

    def reset(self) -> None:
        """Reset the fit."""
        self._fit.reset()
