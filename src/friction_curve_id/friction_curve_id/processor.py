"""Messages in, <wheel>/friction_curve out: one processor a wheel, or one for the vehicle."""

from collections.abc import Mapping, Sequence
from typing import Any

from friction_msgs.msg import FrictionCurve

from friction_curve_id.curve_messages import CurveMessages
from friction_curve_id.inputs import CurveInputs
from friction_curve_id.interface import Reason, RestartCause
from friction_curve_id.parameters import TYRE_FORCE, VEHICLE, FrictionCurveParameters
from friction_curve_id.tyre_force_inputs import TyreForceInputs
from friction_curve_id.vehicle_inputs import VehicleInputs
from friction_curve_id.wheel_inputs import WheelInputs
from friction_runtime.aligner import AlignedSample, Aligner
from friction_runtime.processor import Health, Level, Output, Report, silent
from friction_runtime.stamps import to_nanoseconds
from vehicle_models.vehicle import Vehicle

_SILENT_AFTER = 0.25
"""[s]"""
_QUIET = (Reason.OK, Reason.TOO_FEW_SAMPLES, Reason.PEAK_NOT_PASSED, Reason.LOW_SPEED, Reason.NO_EXCITATION)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_SLIP, Reason.NO_TORQUE, Reason.NO_ACCELERATION)
"""Reasons that no wait cures."""


class CurveProcessor:
    """Layer 2 of friction_curve_id. Fires for each sample of its primary, once the other inputs have reached it."""

    def __init__(
        self,
        name: str,
        frame_id: str,
        inputs: CurveInputs,
        parameters: FrictionCurveParameters,
        report: Report = silent,
    ) -> None:
        """Publish the curve of `name` (a wheel, or 'vehicle'); `report` takes what a person should know."""
        self._name = name
        self._inputs = inputs
        self._report = report
        self._topic = f"{name}/friction_curve"
        self._aligner: Aligner[Any] = Aligner(inputs.primary, inputs.aligned, parameters.deadline)
        self._messages = CurveMessages(name, frame_id, parameters.method, parameters.abs_activation_slip)
        self._cause = RestartCause.NONE
        self._last: FrictionCurve | None = None
        self._silent = ""
        self.sensors = inputs.sensors
        self.estimates = inputs.estimates
        self.outputs: Mapping[str, type] = {self._topic: FrictionCurve}

    def reset(self) -> None:
        """Start anew; the next estimate says that it restarted on request."""
        self._aligner.reset()
        self._restart(RestartCause.REQUEST)

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message, return what follows from it."""
        if topic == self._inputs.primary:
            stamp = to_nanoseconds(message.header.stamp)
            refusal = self._aligner.offer_primary(stamp, self._inputs.read_primary(message))
            self._silent = ""
        else:
            reading = self._inputs.read(topic, message)
            refusal = reading if isinstance(reading, str) else self._aligner.offer(topic, reading[0], reading[1])
        if refusal is not None:
            self._report("warning", f"{refusal}: sample refused")
        return [self._fire(sample) for sample in self._aligner.ready()]

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Note silence of the primary for diagnostics: without a sample there is no stamp to speak of."""
        age = ages.get(self._inputs.primary, 0.0)
        self._silent = f"{self._inputs.primary}: no message for {age:.2f} s" if age > _SILENT_AFTER else ""
        return []

    def health(self) -> Health:
        """State for diagnostics."""
        last = self._last
        if self._silent or last is None:
            return Health(self._name, Level.ERROR, self._silent or f"{self._inputs.primary}: no sample yet")
        reason = Reason(last.reason)
        level = Level.OK if reason in _QUIET else Level.ERROR if reason in _BROKEN else Level.WARN
        values = {
            "lambda_max [-]": f"{last.lambda_max:.4f}",
            "lambda_max standard deviation [-]": f"{last.lambda_max_stddev:.4f}",
            "mu_max [-]": f"{last.mu_max:.4f}",
            "samples": str(last.samples),
            "restarts": str(last.restarts),
            "reason": reason.name.lower(),
        }
        return Health(self._name, level, last.reason_text or "ok", values)

    def _fire(self, sample: AlignedSample[Any]) -> Output:
        if sample.rewound:
            self._restart(RestartCause.GAP)
            self._report("info", f"{self._inputs.primary}: stamps jumped back, {self._name} started anew")
        answer, slip = self._inputs.answer(sample)
        self._last = self._messages.message(sample.stamp, answer, slip, self._cause)
        return self._topic, self._last

    def _restart(self, cause: RestartCause) -> None:
        self._inputs.reset()
        self._messages.restart()
        self._cause = cause


def build(parameters: FrictionCurveParameters, vehicle: Vehicle, report: Report = silent) -> list[CurveProcessor]:
    """Make the processors: one for each wheel of the car, or a single one for the method 'vehicle'."""
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
