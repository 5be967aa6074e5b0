"""Messages of all wheels in, <wheel>/friction_curve of every wheel and vehicle_fit out: layer 2 of the method 'car'."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite, nan
from typing import Any, Final

from friction_msgs.msg import FrictionCurve, VehicleFit
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_curve_id.car import CarEstimator, CarSample
from friction_curve_id.car.braked_speed import BrakedSpeed
from friction_curve_id.car.gain_over_mass import GainOverMass
from friction_curve_id.interface import CurveEstimate, Refusal, RestartCause
from friction_curve_id.parameters import CAR, FrictionCurveParameters
from friction_curve_id.ros.curve_messages import CurveMessages, health_of
from friction_curve_id.ros.inputs import IMU
from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.lateral_inputs import MEASURED, NOT_MEASURED, LateralInput
from friction_runtime.messages import header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, WheelSpeeds
from sensor_monitor.acceleration_unit import AccelerationUnit
from sensor_monitor.pressure_unit import PressureUnit
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_PRESSURE
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

VEHICLE_FIT = "vehicle_fit"
_UNKNOWN: Final = (nan,)
_NO_IMU: Final = (nan, *NOT_MEASURED)
_PERIOD: Final = 1.0
"""Time between two messages of what was learned [s]; one more when a braking was learned from."""


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
        self._pressure_units = {topic: PressureUnit(vehicle, wheel) for topic, wheel in self._pressures.items()}
        self._braked_speed = BrakedSpeed(vehicle)
        self._acceleration_unit = AccelerationUnit(largest=inf, lasting=2)  # no slip is in that speed
        self._mounting, self._lateral = vehicle.accelerometer, LateralInput(vehicle.accelerometer)
        self._wheel_speeds = WheelSpeeds(vehicle, self._wheels, report)
        self._estimator = CarEstimator(vehicle, parameters.car)
        self._messages = {
            wheel: CurveMessages(wheel, wheel, CAR, parameters.abs_activation_slip, parameters.highest_mu)
            for wheel in self._wheels
        }
        self._cause = RestartCause.NONE
        self._last: list[FrictionCurve] = []
        self._told: int | None = None
        """Stamp of the last vehicle_fit [ns]."""
        self._brakings = (0, 0)
        self.sensors: Mapping[str, type] = {
            WHEEL_STATES: JointState,
            IMU: Imu,
            **dict.fromkeys(self._pressures, FluidPressure),
        }
        self.estimates: Mapping[str, type] = {}
        self.outputs: Mapping[str, type] = {VEHICLE_FIT: VehicleFit}
        for messages in self._messages.values():
            self.outputs |= messages.topics

    def _payload(self, message: JointState) -> tuple[float, ...]:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Any) -> str | None:
        stamp = to_nanoseconds(message.header.stamp)
        if topic == IMU:
            # The estimator knows scale and pitch as unknowns of its own.
            along = self._mounting.without_bias(message.linear_acceleration)
            return self._aligner.offer(topic, stamp, (along, *self._lateral.read(message)))
        # No delay is taken off: the age of the pressures is an unknown too.
        pressure = float(message.fluid_pressure)
        if not abs(pressure) <= HIGHEST_PRESSURE:
            self._pressure_units[topic].refuse(stamp, pressure)
            return f"{topic}: {pressure} Pa is not a brake pressure"
        return self._aligner.offer(topic, stamp, (pressure,))

    def _fire(self, sample: AlignedSample[tuple[float, ...]]) -> list[Output]:
        pressures = [sample.values.get(topic, _UNKNOWN)[0] for topic in self._pressures]
        acceleration, leftward, yaw_rate, known = sample.values.get(IMU, _NO_IMU)
        across = (leftward, yaw_rate) if known == MEASURED else (nan, nan)
        taken = CarSample(sample.time, sample.payload, pressures, acceleration, *across)
        if wrong_unit := self._wrong_unit(sample, pressures, acceleration):
            # All wheels are fitted together, so one wrong unit spoils them all.
            answers: Sequence[CurveEstimate | Refusal] = [Refusal(Reason.BAD_INPUT, wrong_unit)] * len(self._wheels)
        else:
            answers = self._estimator.update(taken)
        self._last = []
        outputs: list[Output] = []
        debug: list[Output] = []
        for (topic, wheel), answer in zip(self._pressures.items(), answers, strict=True):
            found: CurveEstimate | Refusal = answer
            if isinstance(answer, Refusal) and topic in sample.missing and not wrong_unit:
                found = Refusal(Reason.NO_PRESSURE, sample.missing[topic])
            curve, internals = self._messages[wheel].outputs(sample.stamp, found, nan, self._cause)
            self._last.append(curve[1])
            outputs.append(curve)
            debug.append(internals)
        outputs += debug  # nobody waits for these
        if self._to_be_told(sample.stamp):
            found_of_car = self._estimator.learner.found
            self._told = sample.stamp
            outputs.append((VEHICLE_FIT, vehicle_fit(found_of_car, sample.stamp)))
        return outputs

    def _wrong_unit(
        self, sample: AlignedSample[tuple[float, ...]], pressures: Sequence[float], acceleration: float
    ) -> str:
        """Return which unit of pressures or accelerometer seems to be wrong, empty where none does."""
        found = ""
        for (topic, unit), wheel_speed, pressure in zip(
            self._pressure_units.items(), sample.payload, pressures, strict=True
        ):
            unit.update(sample.stamp, wheel_speed, pressure)
            found = f"{topic}: {unit.text}" if unit.text else found
        if not self._acceleration_unit.known:
            speed = self._braked_speed.update(sample.time, sample.payload, pressures)
            if isfinite(speed) and isfinite(acceleration):
                self._acceleration_unit.update(sample.stamp, speed, acceleration)
        return found or self._acceleration_unit.text

    def _to_be_told(self, stamp: int) -> bool:
        brakings, self._brakings = self._brakings, self._estimator.learner.brakings
        return brakings != self._brakings or self._told is None or abs(stamp - self._told) >= _PERIOD * NANOSECONDS

    def _forget(self) -> None:
        self._last = []
        for unit in self._pressure_units.values():
            unit.reset()
        self._braked_speed.reset()
        self._acceleration_unit.reset()
        self._lateral.reset()
        self._restart(RestartCause.REQUEST)

    def _start_again(self, stamp: int) -> None:
        self._restart(RestartCause.GAP)

    def _state(self) -> tuple[Level, str]:
        worst = max(self._last, key=health_of, default=None)
        if worst is None:
            return Level.OK, ""
        return health_of(worst), worst.validity.text

    def _values(self) -> dict[str, str]:
        values = {}
        for last in self._last:
            values[f"{last.wheel} lambda_max [-]"] = f"{last.lambda_max:.4f}"
            values[f"{last.wheel} mu_max [-]"] = f"{last.mu_max:.4f}"
            values[f"{last.wheel} reason"] = Reason(last.validity.reason).name.lower()
        found = self._estimator.learner.found
        for axle, value, stddev in (
            ("front", found.front, found.front_stddev),
            ("rear", found.rear, found.rear_stddev),
        ):
            values[f"brake gain over mass, {axle} [N m/(Pa kg)]"] = f"{value:.3e} +- {stddev:.1e}"
        values["brakings learned from"] = str(found.brakings)
        return values

    def _restart(self, cause: RestartCause) -> None:
        self._estimator.reset()
        for messages in self._messages.values():
            messages.restart()
        self._cause = cause
        self._told = None


def vehicle_fit(found: GainOverMass, stamp: int) -> VehicleFit:
    """Return what was learned as a message of a stamp [ns]."""
    message = VehicleFit()
    message.header = header_at(stamp, "base_link")
    message.wheel = "vehicle"
    message.gain_over_mass_front = found.front
    message.gain_over_mass_front_stddev = found.front_stddev
    message.gain_over_mass_rear = found.rear
    message.gain_over_mass_rear_stddev = found.rear_stddev
    message.brakings, message.refused, message.restarts = found.brakings, found.refused, found.restarts
    text = "" if found.brakings else "waiting for a braking to learn from"
    message.validity = validity("vehicle", found.reason, text)
    return message
