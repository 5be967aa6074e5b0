"""Messages of all wheels in, <wheel>/friction_curve of every wheel out: layer 2 of the method 'car'."""

from collections.abc import Mapping
from math import nan
from typing import Any

from friction_msgs.msg import FrictionCurve
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.curve_messages import CurveMessages, health_of
from friction_curve_id.inputs import IMU
from friction_curve_id.interface import CurveEstimate, Reason, Refusal, RestartCause
from friction_curve_id.parameters import FrictionCurveParameters
from friction_runtime.aligned_processor import AlignedProcessor
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.primary import Primary
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.stamps import to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.plausible import HIGHEST_PRESSURE
from vehicle_models.vehicle import Vehicle


class CarProcessor(AlignedProcessor[tuple[float, ...]]):
    """One estimator for the car, triggered by wheel_states; without an accelerometer intervals are wider."""

    def __init__(self, vehicle: Vehicle, parameters: FrictionCurveParameters, report: Report = silent) -> None:
        """Publish a curve for every wheel; `report` is the log function."""
        max_gap = parameters.car.max_gap
        self._wheels = vehicle.wheel_names
        self._pressures = {f"{wheel}/brake_pressure": wheel for wheel in self._wheels}
        aligned = [AlignedInput(topic, max_gap) for topic in self._pressures]
        aligned.append(AlignedInput(IMU, max_gap))
        super().__init__("car", Primary(WHEEL_STATES, "car", report), aligned, parameters.deadline, (IMU,))
        self._mounting = vehicle.accelerometer
        self._wheel_speeds = WheelSpeeds(vehicle, self._wheels, report)
        self._estimator = CarEstimator(vehicle, parameters.car)
        self._messages = {
            wheel: CurveMessages(wheel, wheel, parameters.method, parameters.abs_activation_slip)
            for wheel in self._wheels
        }
        self._cause = RestartCause.NONE
        self._last: list[FrictionCurve] = []
        self.sensors: Mapping[str, type] = {
            WHEEL_STATES: JointState,
            IMU: Imu,
            **dict.fromkeys(self._pressures, FluidPressure),
        }
        self.estimates: Mapping[str, type] = {}
        self.outputs: Mapping[str, type] = {f"{wheel}/friction_curve": FrictionCurve for wheel in self._wheels}

    def _payload(self, message: JointState) -> tuple[float, ...]:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == IMU:
            # The estimator knows scale and pitch as unknowns of its own.
            reading = self._mounting.without_offset(message.linear_acceleration)
        else:
            # No delay is taken off: the age of the pressures is an unknown too.
            reading = float(message.fluid_pressure)
            if not abs(reading) <= HIGHEST_PRESSURE:
                return f"{topic}: {reading} Pa is not a brake pressure"
        return self._aligner.offer(topic, to_nanoseconds(message.header.stamp), (reading,))

    def _fire(self, sample: AlignedSample[tuple[float, ...]]) -> list[Output]:
        pressures = [sample.values.get(topic) for topic in self._pressures]
        acceleration = sample.values.get(IMU)
        answers = self._estimator.update(
            CarSample(
                sample.stamp / NANOSECONDS,
                sample.payload,
                [nan if pressure is None else pressure[0] for pressure in pressures],
                nan if acceleration is None else acceleration[0],
            )
        )
        self._last = []
        outputs: list[Output] = []
        for (topic, wheel), answer in zip(self._pressures.items(), answers, strict=True):
            found: CurveEstimate | Refusal = answer
            if isinstance(answer, Refusal) and topic in sample.missing:
                found = Refusal(Reason.NO_TORQUE, sample.missing[topic])
            message = self._messages[wheel].message(sample.stamp, found, nan, self._cause)
            self._last.append(message)
            outputs.append((f"{wheel}/friction_curve", message))
        return outputs

    def _forget(self) -> None:
        self._last = []
        self._restart(RestartCause.REQUEST)

    def _start_again(self, stamp: int) -> None:
        self._restart(RestartCause.GAP)

    def _state(self) -> tuple[Level, str]:
        worst = max(self._last, key=health_of, default=None)
        if worst is None:
            return Level.OK, ""
        return health_of(worst), worst.reason_text

    def _values(self) -> dict[str, str]:
        values = {}
        for last in self._last:
            values[f"{last.wheel} lambda_max [-]"] = f"{last.lambda_max:.4f}"
            values[f"{last.wheel} mu_max [-]"] = f"{last.mu_max:.4f}"
            values[f"{last.wheel} reason"] = Reason(last.reason).name.lower()
        gains = self._estimator.gain_over_mass
        if gains is not None:
            for axle, (value, stddev) in zip(("front", "rear"), gains, strict=True):
                values[f"brake gain over mass, {axle} [%]"] = f"{100.0 * value:+.1f} +- {100.0 * stddev:.1f}"
        return values

    def _restart(self, cause: RestartCause) -> None:
        self._estimator.reset()
        for messages in self._messages.values():
            messages.restart()
        self._cause = cause
