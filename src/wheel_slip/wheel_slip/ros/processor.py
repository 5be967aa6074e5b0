"""wheel_states, imu/data, vehicle_velocity and <wheel>/brake_pressure in, <wheel>/slip out: one for the car."""

from collections.abc import Mapping
from math import isfinite, nan, sqrt
from typing import Final

from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.messages import header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, WheelSpeeds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION, HIGHEST_SPEED
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimate import Mode, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.brake_pressures import BrakePressures
from wheel_slip.speed_queue import SpeedQueue
from wheel_slip.speed_sample import SpeedSample

IMU: Final = "imu/data"
VEHICLE_VELOCITY: Final = "vehicle_velocity"
_QUIET = (Reason.OK, Reason.LOW_SPEED)
"""Reasons that belong to ordinary driving."""


class CarProcessor(AlignedProcessor[tuple[float, ...]]):
    """Layer 2 of wheel_slip: fires on wheel_states."""

    def __init__(self, vehicle: Vehicle, parameters: WheelSlipParameters, report: Report = silent) -> None:
        """Build for a car; `report` is the log function."""
        self._p = parameters
        self._wheels = vehicle.wheel_names
        self._accelerometer = vehicle.accelerometer
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, VEHICLE_VELOCITY: TwistWithCovarianceStamped}
        inputs: list[AlignedInput] = []
        if parameters.use_imu:
            self.sensors = {**self.sensors, IMU: Imu}
            inputs.append(AlignedInput(IMU, parameters.estimator.max_gap))
        self._brakes = BrakePressures(vehicle, parameters.estimator.max_gap)
        self.sensors = {**self.sensors, **self._brakes.sensors}
        optional = (VEHICLE_VELOCITY, *self._brakes.sensors)
        self.estimates: Mapping[str, type] = {}
        self.outputs: Mapping[str, type] = {f"{wheel}/slip": WheelSlip for wheel in self._wheels}
        primary = Primary(WHEEL_STATES, "car", report)
        super().__init__("car", primary, inputs, parameters.deadline, optional)
        self._wheel_speeds = WheelSpeeds(vehicle, self._wheels, report)
        self._speeds: SpeedQueue[tuple[float, float]] = SpeedQueue(parameters.speed_sensor.wait)
        self._estimator = SlipEstimator(vehicle, parameters.estimator)
        self._forget()

    def _payload(self, message: JointState) -> tuple[float, ...]:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Imu | TwistWithCovarianceStamped | FluidPressure) -> str | None:
        if topic in self._brakes.sensors:
            return self._brakes.offer(topic, message)
        stamp = to_nanoseconds(message.header.stamp)
        if topic == IMU:
            return self._aligner.offer(topic, stamp, (self._acceleration(message),))
        return self._offer_speed(stamp, message)

    def _forget(self) -> None:
        self._speeds.reset()
        self._brakes.reset()
        self._estimator.reset()
        self._last: dict[str, WheelEstimate] = {}
        self._missing = ""
        self._stamp = 0

    def _start_again(self, stamp: int) -> None:
        self._estimator.reset()

    def _state(self) -> tuple[Level, str]:
        if self._estimator.vehicle.mode is Mode.WAITING:
            return Level.ERROR, "no vehicle speed"
        bad = [f"{wheel}: {estimate.text}" for wheel, estimate in self._last.items() if estimate.reason not in _QUIET]
        if self._estimator.vehicle.accelerometer_text:
            bad.append(f"{IMU}: {self._estimator.vehicle.accelerometer_text}; left out")
        if self._estimator.vehicle.sensor_text:
            bad.append(f"{VEHICLE_VELOCITY}: {self._estimator.vehicle.sensor_text}")
        if self._estimator.radius_text:
            bad.append(self._estimator.radius_text)
        if self._missing:
            bad.append(self._missing)
        return Level.WARN if bad else Level.OK, "; ".join(bad)

    def _values(self) -> dict[str, str]:
        car = self._estimator.vehicle
        values = {
            **car.health_values(self._stamp),
            "radii [m]": ", ".join(f"{radius:.4f}" for radius in self._estimator.radii),
            "their relative standard deviations [%]": ", ".join(
                f"{100.0 * sqrt(variance):.2f}" for variance in self._estimator.radius_variances
            ),
            "late samples of vehicle_velocity": str(self._speeds.late),
        }
        for wheel, estimate in self._last.items():
            values[f"{wheel} reason"] = estimate.text or "ok"
        return values

    def _acceleration(self, message: Imu) -> float:
        """Acceleration forward [m/s^2], NaN where it is garbage."""
        acceleration = self._accelerometer.forward(message.linear_acceleration)
        return acceleration if abs(acceleration) <= HIGHEST_ACCELERATION else nan

    def _offer_speed(self, stamp: int, message: TwistWithCovarianceStamped) -> str | None:
        speed, variance = float(message.twist.twist.linear.x), float(message.twist.covariance[0])
        if not abs(speed) <= HIGHEST_SPEED:
            return f"{VEHICLE_VELOCITY}: {speed} is not a vehicle speed"
        if not (isfinite(variance) and variance > 0.0):
            variance = self._p.speed_sensor.stddev**2
        refusal = self._speeds.offer(stamp, (speed, variance))
        return None if refusal is None else f"{VEHICLE_VELOCITY}: {refusal}"

    def _fire(self, sample: AlignedSample[tuple[float, ...]]) -> list[Output]:
        self._stamp = sample.stamp
        self._missing = sample.missing.get(IMU, "")
        latency = round(self._p.speed_sensor.latency * NANOSECONDS)
        measured = [
            SpeedSample(when - latency, *value) for when, value in self._speeds.due(sample.stamp, sample.rewound)
        ]
        acceleration = sample.values[IMU][0] if IMU in sample.values else None
        torques = self._brakes.torques(sample.stamp, sample.rewound)
        estimates = self._estimator.update(sample.stamp, sample.payload, acceleration, measured, torques)
        outputs: list[Output] = []
        for wheel, topic, estimate in zip(self._wheels, self.outputs, estimates, strict=True):
            self._last[wheel] = estimate
            outputs.append((topic, _message(sample.stamp, wheel, estimate)))
        return outputs


def build(parameters: WheelSlipParameters, vehicle: Vehicle, report: Report = silent) -> list[CarProcessor]:
    """Make the processors: one for the whole car."""
    return [CarProcessor(vehicle, parameters, report)]


def _message(stamp: int, wheel: str, estimate: WheelEstimate) -> WheelSlip:
    message = WheelSlip()
    message.header = header_at(stamp, wheel)
    message.wheel = wheel
    message.slip = estimate.slip
    message.slip_rate = estimate.slip_rate
    message.vehicle_speed = estimate.vehicle_speed
    message.wheel_speed = estimate.wheel_speed
    message.slip_stddev = sqrt(estimate.slip_variance)
    message.slip_rate_stddev = sqrt(estimate.slip_rate_variance)
    message.vehicle_speed_stddev = sqrt(estimate.vehicle_speed_variance)
    message.speed_source = int(estimate.source)
    message.mode = int(estimate.mode)
    message.validity = validity(wheel, estimate.reason, estimate.text)
    return message
