"""wheel_states, imu/data, vehicle_velocity and <wheel>/brake_pressure in, <wheel>/slip and vehicle_speed out."""

from collections.abc import Mapping
from math import isfinite, nan, sqrt
from typing import Final

import numpy as np
from friction_msgs.msg import WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.lateral_inputs import yaw_rate_of
from friction_runtime.messages import header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, WheelSpeeds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION, HIGHEST_SPEED
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from wheel_slip.estimate import Hypotheses, SpeedSample, WheelEstimate
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.held_samples import BrakePressures, HeldSamples
from wheel_slip.wheel_equation import B, U

IMU: Final = "imu/data"
VEHICLE_VELOCITY: Final = "vehicle_velocity"
VEHICLE_SPEED: Final = "vehicle_speed"
_UNKNOWN: Final = 1e6
"""Variance of what is not estimated of a twist, as consumers of covariances expect it."""
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
        self._slips = [f"{wheel}/slip" for wheel in self._wheels]
        of_car = {VEHICLE_SPEED: TwistWithCovarianceStamped}
        self.outputs: Mapping[str, type] = {**dict.fromkeys(self._slips, WheelSlip), **of_car}
        primary = Primary(WHEEL_STATES, "car", report)
        super().__init__("car", primary, inputs, parameters.deadline, optional)
        self._wheel_speeds = WheelSpeeds(vehicle, self._wheels, report)
        self._speeds: HeldSamples[tuple[float, float]] = HeldSamples()
        self._estimator = SlipEstimator(vehicle, parameters.estimator)
        self._forget()

    def _payload(self, message: JointState) -> tuple[float, ...]:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Imu | TwistWithCovarianceStamped | FluidPressure) -> str | None:
        if topic in self._brakes.sensors:
            return self._brakes.offer(topic, message)
        stamp = to_nanoseconds(message.header.stamp)
        if topic == IMU:
            return self._aligner.offer(topic, stamp, self._motion(message))
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
        if not self._estimator.car.started:
            return Level.ERROR, "no vehicle speed"
        bad = [f"{wheel}: {estimate.text}" for wheel, estimate in self._last.items() if estimate.reason not in _QUIET]
        if self._estimator.accelerometer_text:
            bad.append(f"{IMU}: {self._estimator.accelerometer_text}")
        if self._estimator.pressure_text:
            bad.append(f"brake pressures: {self._estimator.pressure_text}")
        if self._estimator.speed_sensor.text:
            bad.append(f"{VEHICLE_VELOCITY}: {self._estimator.speed_sensor.text}")
        if self._estimator.radius_text:
            bad.append(self._estimator.radius_text)
        if self._missing:
            bad.append(self._missing)
        return Level.WARN if bad else Level.OK, "; ".join(bad)

    def _values(self) -> dict[str, str]:
        car, hypotheses = self._estimator.car, self._estimator.hypotheses
        errors, stddevs = car.radius_errors
        values = {
            "vehicle speed [m/s]": f"{car.speed:.3f}",
            "vehicle speed standard deviation [m/s]": f"{sqrt(car.variance):.3f}",
            "yaw rate [rad/s]": f"{float(car.mean[U]):.3f}",
            "accelerometer offset [m/s^2]": f"{car.mean[B]:.3f}",
            "accelerometer offset standard deviation [m/s^2]": f"{sqrt(car.covariance[B, B]):.3f}",
            "errors of the radii [%]": ", ".join(f"{100.0 * error:.2f}" for error in errors),
            "their standard deviations [%]": ", ".join(f"{100.0 * stddev:.2f}" for stddev in stddevs),
            "late samples of vehicle_velocity": str(self._speeds.late),
            **{f"probability: {name}": f"{value:.3f}" for name, value in hypotheses._asdict().items()},
        }
        for wheel, estimate in self._last.items():
            values[f"{wheel} reason"] = estimate.text or "ok"
        return values

    def _motion(self, message: Imu) -> tuple[float, float, float]:
        """Acceleration forward [m/s^2], NaN where it is garbage; yaw rate [rad/s], and 1.0 where that is known."""
        acceleration = self._accelerometer.forward(message.linear_acceleration)
        yaw_rate = yaw_rate_of(message)
        known = isfinite(yaw_rate)
        forward = acceleration if abs(acceleration) <= HIGHEST_ACCELERATION else nan
        return forward, yaw_rate if known else 0.0, float(known)

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
        acceleration, yaw_rate, known = sample.values.get(IMU, (None, None, 0.0))
        torques = self._brakes.torques(sample.stamp, sample.rewound)
        estimates = self._estimator.update(
            sample.stamp, sample.payload, acceleration, measured, torques, yaw_rate if known == 1.0 else None
        )
        told, by_sensor = self._estimator.hypotheses, self._estimator.speed_sensor.speaks(sample.stamp)
        outputs: list[Output] = []
        for wheel, topic, estimate in zip(self._wheels, self._slips, estimates, strict=True):
            self._last[wheel] = estimate
            outputs.append((topic, _message(sample.stamp, wheel, estimate, told, by_sensor)))
        if isfinite(estimates[0].vehicle_speed):
            outputs.append((VEHICLE_SPEED, self._twist(sample.stamp)))
        return outputs

    def _twist(self, stamp: int) -> TwistWithCovarianceStamped:
        """Speed of the middle of the rear axle and yaw rate."""
        car, message = self._estimator.car, TwistWithCovarianceStamped()
        message.header = header_at(stamp, "base_link")
        message.twist.twist.linear.x, message.twist.twist.angular.z = car.speed, float(car.mean[U])
        covariance = np.diag([_UNKNOWN] * 6)
        covariance[0, 0] = car.variance + self._estimator.speed_sensor.undecided
        covariance[5, 5] = float(car.covariance[U, U])
        message.twist.covariance = covariance.ravel()
        return message


def build(parameters: WheelSlipParameters, vehicle: Vehicle, report: Report = silent) -> list[CarProcessor]:
    """Make the processors: one for the whole car."""
    return [CarProcessor(vehicle, parameters, report)]


def _message(stamp: int, wheel: str, estimate: WheelEstimate, told: Hypotheses, by_sensor: bool) -> WheelSlip:
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
    message.speed_measured = by_sensor and told.speed_sensor_wrong < 0.5
    message.slope_changed_probability = told.slope_changed
    message.accelerometer_wrong_probability = told.accelerometer_wrong
    message.pressures_wrong_probability = told.pressures_wrong
    message.speed_sensor_wrong_probability = told.speed_sensor_wrong
    message.validity = validity(wheel, estimate.reason, estimate.text)
    return message
