"""Messages of all wheels in, <wheel>/friction_slope of every wheel out: layer 2 of the method slip_position."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any, Final

import numpy as np
from friction_msgs.msg import FrictionSlope, WheelSlip
from sensor_msgs.msg import FluidPressure, Imu, JointState

from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.lateral_inputs import MEASURED, LateralInput
from friction_runtime.messages import slip_fault, slip_is_known, to_nanoseconds
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from friction_slope.estimate import SlopeEstimate
from friction_slope.parameters import FrictionSlopeParameters
from friction_slope.ros.messages import estimate_message
from friction_slope.slip_position.detector import CarDetector
from friction_slope.slip_position.estimator import CarSample
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

_IMU: Final = "imu/data"
_QUIET = (Reason.OK, Reason.NOT_READY, Reason.LOW_SPEED, Reason.NOT_BRAKING, Reason.NOT_LASTING)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_PRESSURE,)
"""Reasons that do not go away by waiting."""
_NO_SLIP = (nan, nan, nan, 0.0)
_NO_IMU = (nan, nan, nan, 0.0)


class CarProcessor(AlignedProcessor[tuple[float, ...]]):
    """The signs of all wheels, triggered by wheel_states."""

    def __init__(self, vehicle: Vehicle, parameters: FrictionSlopeParameters, report: Report = silent) -> None:
        """Build for a car; `report` is the log function."""
        p = parameters.detector
        self._wheels = vehicle.wheel_names
        self._brakes = {(brake := BrakeTorque(vehicle, wheel)).topic: brake for wheel in self._wheels}
        self._slips = {f"{wheel}/slip": wheel for wheel in self._wheels}
        aligned = [AlignedInput(topic, p.max_gap) for topic in (*self._brakes, *self._slips)]
        aligned.append(AlignedInput(_IMU, p.max_gap, optional=True))
        super().__init__("car", Primary(WHEEL_STATES, "car", report), aligned, parameters.deadline, (_IMU,))
        self._topics = {wheel: f"{wheel}/friction_slope" for wheel in self._wheels}
        self.sensors: Mapping[str, type] = {
            WHEEL_STATES: JointState,
            **dict.fromkeys(self._brakes, FluidPressure),
            _IMU: Imu,
        }
        self.estimates: Mapping[str, type] = dict.fromkeys(self._slips, WheelSlip)
        self.outputs: Mapping[str, type] = dict.fromkeys(self._topics.values(), FrictionSlope)
        self._accelerometer = vehicle.accelerometer
        self._wheel_speeds = WheelSpeeds(vehicle, self._wheels, report)
        self._detector = CarDetector(vehicle, p)
        self._lateral = LateralInput(vehicle.accelerometer)
        self._slip_faults = dict.fromkeys(self._slips, "")
        self._last: Sequence[SlopeEstimate] = ()

    def _payload(self, message: JointState) -> tuple[float, ...]:
        return self._wheel_speeds.read(message)

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == _IMU:
            return self._offer_motion(message)
        if topic in self._slips:
            return self._offer_slip(topic, message)
        read = self._brakes[topic].read(message)
        return read if isinstance(read, str) else self._aligner.offer(topic, read[0], (read[1],))

    def _offer_motion(self, message: Imu) -> str | None:
        forward = self._accelerometer.forward(message.linear_acceleration)
        if not (abs(forward) <= HIGHEST_ACCELERATION and abs(message.linear_acceleration.y) <= HIGHEST_ACCELERATION):
            return f"{_IMU}: {forward} and {message.linear_acceleration.y} m/s^2 are no accelerations of a car"
        values = (forward, *self._lateral.read(message))
        return self._aligner.offer(_IMU, to_nanoseconds(message.header.stamp), values)

    def _offer_slip(self, topic: str, message: WheelSlip) -> str | None:
        # Validity travels as a number, so that an interpolation between a known and an unknown slip is unknown.
        values = (message.slip, message.slip_stddev, message.vehicle_speed, 1.0)
        self._slip_faults[topic] = slip_fault(topic, message)
        known = slip_is_known(message) and all(map(isfinite, values))
        return self._aligner.offer(topic, to_nanoseconds(message.header.stamp), values if known else (0.0,) * 4)

    def _fire(self, sample: AlignedSample[tuple[float, ...]]) -> list[Output]:
        torques = [sample.values.get(topic, (nan,))[0] for topic in self._brakes]
        slips = np.array([sample.values.get(topic, _NO_SLIP) for topic in self._slips])
        slips[slips[:, 3] != 1.0] = nan
        forward, leftward, yaw_rate, known = sample.values.get(_IMU, _NO_IMU)
        across = known == MEASURED
        found = self._detector.update(
            CarSample(
                stamp=sample.stamp,
                wheel_speed=np.array(sample.payload),
                torque=np.array(torques),
                slip=slips[:, 0],
                slip_stddev=slips[:, 1],
                ground_speed=slips[:, 2],
                forward=forward,
                leftward=leftward if across else nan,
                yaw_rate=yaw_rate if across else nan,
            )
        )
        for estimate, (topic, brake), speed, torque, slip in zip(
            found, self._brakes.items(), sample.payload, torques, self._slips, strict=True
        ):
            if wrong_unit := brake.wrong_unit(sample.stamp, speed, torque):
                estimate.sign, estimate.reason, estimate.text = 0, Reason.BAD_INPUT, wrong_unit
            elif estimate.reason is Reason.NO_PRESSURE:
                estimate.text = sample.missing.get(topic, estimate.text)
            elif estimate.reason is Reason.NO_SLIP:
                estimate.text = sample.missing.get(slip, self._slip_faults[slip] or f"{slip}: not valid")
        self._last = found
        return [
            (topic, estimate_message(wheel, sample.stamp, estimate))
            for (wheel, topic), estimate in zip(self._topics.items(), found, strict=True)
        ]

    def _forget(self) -> None:
        self._detector.reset()
        for brake in self._brakes.values():
            brake.reset()
        self._lateral.reset()
        self._slip_faults = dict.fromkeys(self._slips, "")
        self._last = ()

    def _start_again(self, stamp: int) -> None:
        self._detector.reset()

    def _state(self) -> tuple[Level, str]:
        levels = [(level_of(each.reason, _QUIET, _BROKEN), each.text) for each in self._last]
        return max(levels, key=lambda each: each[0], default=(Level.OK, ""))

    def _values(self) -> dict[str, str]:
        values = {}
        for wheel, last in zip(self._wheels, self._last, strict=False):
            values[f"{wheel} sign"] = str(last.sign)
            values[f"{wheel} P(beyond the peak)"] = f"{last.probability:.3f}"
            values[f"{wheel} crossings"] = str(last.crossings)
        return values
