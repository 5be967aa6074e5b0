"""Friction curves and their debug messages: one processor per wheel, one for the vehicle, or one for all wheels."""

from collections.abc import Mapping
from typing import Any

from friction_msgs.msg import FrictionCurve, WheelSlip

from friction_curve_id.interface import RestartCause
from friction_curve_id.parameters import AUTO, CAR, TYRE_FORCE, VEHICLE, FrictionCurveParameters
from friction_curve_id.ros.car_processor import CarProcessor
from friction_curve_id.ros.curve_messages import CurveMessages, health_of
from friction_curve_id.ros.inputs import CurveInputs
from friction_curve_id.ros.tyre_force_inputs import TyreForceInputs
from friction_curve_id.ros.vehicle_inputs import VehicleInputs
from friction_curve_id.ros.wheel_inputs import WheelInputs
from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedSample
from friction_runtime.messages import slip_fault
from friction_runtime.processor import Level, Output, Report, silent
from friction_runtime.reports import without_wheel
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle


class CurveProcessor(AlignedProcessor[Any]):
    """Layer 2 of friction_curve_id: fires on the primary of its inputs."""

    def __init__(
        self,
        name: str,
        frame_id: str,
        inputs: CurveInputs,
        parameters: FrictionCurveParameters,
        report: Report = silent,
    ) -> None:
        """Publish the curve of `name` (a wheel, or 'vehicle'); `report` is the log function."""
        super().__init__(name, Primary(inputs.primary, name, report), inputs.aligned, parameters.deadline)
        self._inputs = inputs
        self._messages = CurveMessages(
            name, frame_id, parameters.method, parameters.abs_activation_slip, parameters.highest_mu
        )
        self._cause = RestartCause.NONE
        self._last: FrictionCurve | None = None
        self._slip_faults: dict[str, str] = {}
        self.sensors = inputs.sensors
        self.estimates = inputs.estimates
        self.outputs: Mapping[str, type] = self._messages.topics

    def _payload(self, message: Any) -> Any:
        return self._inputs.read_primary(message)

    def _take(self, topic: str, message: Any) -> str | None:
        if self.estimates.get(topic) is WheelSlip:
            self._slip_faults[topic] = slip_fault(topic, message)
        reading = self._inputs.read(topic, message)
        return reading if isinstance(reading, str) else self._aligner.offer(topic, reading[0], reading[1])

    def _fire(self, sample: AlignedSample[Any]) -> list[Output]:
        answer, slip = self._inputs.answer(sample)
        outputs = self._messages.outputs(sample.stamp, answer, slip, self._cause)
        self._last = outputs[0][1]
        return outputs

    def _forget(self) -> None:
        self._last = None
        self._slip_faults = {}
        self._restart(RestartCause.REQUEST)

    def _start_again(self, stamp: int) -> None:
        self._restart(RestartCause.GAP)

    def _state(self) -> tuple[Level, str]:
        last = self._last
        if last is None:
            return Level.OK, ""
        level, text = health_of(last), without_wheel(self._name, last.validity.text)
        # A method may go on without the slip for a while, or with the speed of before.
        faults = [fault for topic, fault in self._slip_faults.items() if fault and topic not in text]
        if not faults:
            return level, text
        return max(level, Level.WARN), "; ".join([text, *faults] if text else faults)

    def _values(self) -> dict[str, str]:
        last = self._last
        if last is None:
            return {}
        return {
            "lambda_max [-]": f"{last.lambda_max:.4f}",
            "lambda_max standard deviation [-]": f"{last.lambda_max_stddev:.4f}",
            "mu_max [-]": f"{last.mu_max:.4f}",
            "samples": str(last.samples),
            "restarts": str(last.restarts),
            "reason": Reason(last.validity.reason).name.lower(),
        }

    def _restart(self, cause: RestartCause) -> None:
        self._inputs.reset()
        self._messages.restart()
        self._cause = cause


def build(
    parameters: FrictionCurveParameters, vehicle: Vehicle, report: Report = silent
) -> list[CurveProcessor] | list[CarProcessor]:
    """Make the processors: one for each wheel of the car, or a single one for the methods 'car' and 'vehicle'."""
    if parameters.method in (AUTO, CAR):
        return [CarProcessor(vehicle, parameters, report)]
    if parameters.method == VEHICLE:
        inputs = VehicleInputs(vehicle, parameters, report)
        return [CurveProcessor("vehicle", "base_link", inputs, parameters, report)]
    return [
        CurveProcessor(wheel, wheel, _inputs(wheel, vehicle, parameters, report), parameters, report)
        for wheel in vehicle.wheel_names
    ]


def _inputs(wheel: str, vehicle: Vehicle, parameters: FrictionCurveParameters, report: Report) -> CurveInputs:
    if parameters.method == TYRE_FORCE:
        return TyreForceInputs(wheel, parameters)
    return WheelInputs(wheel, vehicle, parameters, report)
