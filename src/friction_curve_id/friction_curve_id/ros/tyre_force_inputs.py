"""Inputs of the method that uses the forces of a smart tyre."""

from collections.abc import Mapping
from math import nan
from typing import Any

from friction_msgs.msg import TyreForce, WheelSlip

from friction_curve_id.chapter.tyre_force import TyreForceFitting, TyreForceSample
from friction_curve_id.interface import CurveEstimate, Refusal
from friction_curve_id.parameters import FrictionCurveParameters
from friction_curve_id.ros.inputs import Reading, wheel_slip
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.reports import of_topic
from vehicle_models.reason import Reason

_SLIP_GAP = 0.1
"""Longest time over which slip is interpolated [s], though forces may come a second apart."""


class TyreForceInputs:
    """CurveInputs of one wheel: fires on <wheel>/tyre_force."""

    def __init__(self, wheel: str, parameters: FrictionCurveParameters) -> None:
        """Fit the curve of `wheel`."""
        self.primary = f"{wheel}/tyre_force"
        self._slip = f"{wheel}/slip"
        self.sensors: Mapping[str, type] = {}
        self.estimates: Mapping[str, type] = {self.primary: TyreForce, self._slip: WheelSlip}
        self.aligned = [AlignedInput(self._slip, min(_SLIP_GAP, parameters.tyre_force.max_gap))]
        self._fitting = TyreForceFitting(parameters.tyre_force)

    def read_primary(self, message: TyreForce) -> TyreForce:
        """Return the message itself."""
        return message

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return the content of <wheel>/slip."""
        return wheel_slip(message)

    def answer(self, sample: AlignedSample[TyreForce]) -> tuple[CurveEstimate | Refusal, float]:
        """Return the answer of the fit, and the slip of <wheel>/slip."""
        values, force = sample.values.get(self._slip), sample.payload
        if values is None or values[3] != 1.0:
            return Refusal(Reason.NO_SLIP, sample.missing.get(self._slip, f"{self._slip}: not valid")), nan
        slip = values[2]
        if not force.validity.valid:
            return Refusal(Reason.BAD_INPUT, of_topic(self.primary, force.validity.text or "not valid")), slip
        return self._fitting.update(TyreForceSample(sample.time, slip, force.fx, force.fz)), slip

    def reset(self) -> None:
        """Reset the fit."""
        self._fitting.reset()
