"""<wheel>/tyre_signals in, <wheel>/contact_patch and <wheel>/tyre_force out, once per revolution."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from friction_msgs.msg import ContactPatch, TyreForce, TyreSignals
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Header

from friction_runtime.processor import Health, Level, Output, Report, silent
from friction_runtime.stamps import NANOSECONDS, from_nanoseconds, to_nanoseconds
from smart_tyre_forces import messages
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.correction import Patch, PatchCorrection
from smart_tyre_forces.forces import Forces, forces
from smart_tyre_forces.front_template import TemplateFit
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.patch_tracker import Passage, PatchTracker
from smart_tyre_forces.reasons import ForceReason, PatchReason
from smart_tyre_forces.tooth_table import ToothTable

_SILENT_AFTER = 0.25
"""[s]"""


class TyreProcessor:
    """Layer 2 of smart_tyre_forces: one wheel."""

    def __init__(
        self, wheel: str, parameters: SmartTyreParameters, calibration: Calibration | None, report: Report = silent
    ) -> None:
        """Build for one wheel.

        Raises:
            ValueError: the calibration does not know the wheel, or lacks the template asked for.
        """
        self.wheel = wheel
        self._topic = f"{wheel}/tyre_signals"
        self.sensors: Mapping[str, type] = {}
        self.estimates: Mapping[str, type] = {self._topic: TyreSignals}
        self.outputs: Mapping[str, type] = {f"{wheel}/contact_patch": ContactPatch, f"{wheel}/tyre_force": TyreForce}
        if parameters.publish_wrench:
            self.outputs = {**self.outputs, f"{wheel}/tyre_wrench": WrenchStamped}
        self._p = parameters
        self._report = report
        self._tyre = calibration.tyre if calibration is not None else None
        self._template = None
        self._wheel_calibration = None
        self._table = None
        if calibration is not None:
            if wheel not in calibration.wheels:
                raise ValueError(f"calibration file {parameters.calibration_file}: no wheel '{wheel}'")
            self._wheel_calibration = calibration.wheels[wheel]
            self._table = ToothTable(np.asarray(self._wheel_calibration.tooth_table))
            if len(self._table) != 2 * parameters.teeth:
                raise ValueError(f"{wheel}: calibrated with {len(self._table) // 2} teeth, parameter 'teeth' differs")
            if parameters.front_method == "template":
                if calibration.template is None:
                    raise ValueError(f"calibration file {parameters.calibration_file}: no template")
                self._template = calibration.template
        self.reset()

    def reset(self) -> None:
        """Start anew, as after construction."""
        refiner = TemplateFit(self._template) if self._template is not None else None
        self._tracker = PatchTracker(self._p.tracker(), self._table, refiner)
        self._correction = PatchCorrection(self._tyre, self._p.tyre_radius, self._p.sample_rate, self._p.zero())
        self._last_stamp: int | None = None
        self._patch: Patch | None = None
        self._forces: Forces | None = None
        self._silent = ""

    def request_shift_zero(self) -> None:
        """Call the shift zero at the next stretch of constant speed."""
        self._correction.request_shift_zero()

    def request_length_zero(self) -> None:
        """Call the length nominal at the next stretch of constant speed, after a change of pressure."""
        self._correction.request_length_zero()

    def process(self, topic: str, message: TyreSignals) -> Sequence[Output]:
        """Take one block, return the revolutions it completes."""
        stamp = to_nanoseconds(message.header.stamp)
        voltage = np.asarray(message.encoder_voltage, dtype=np.float32)
        acceleration = np.asarray(message.radial_acceleration, dtype=np.float32)
        refusal = self._refusal(message, stamp, len(voltage), len(acceleration))
        if refusal:
            self._report("warning", f"{topic}: {refusal}: block refused")
            return []
        if self._last_stamp is not None and stamp < self._last_stamp:
            self._report("warning", f"{topic}: time went back: started anew")
            self.reset()
        self._last_stamp = stamp
        self._silent = ""
        outputs: list[Output] = []
        for passage in self._tracker.push(int(message.first_sample), voltage, acceleration):
            seconds = (passage.time - message.first_sample) / self._p.sample_rate
            header = Header(
                stamp=from_nanoseconds(stamp + round(seconds * NANOSECONDS)), frame_id=message.header.frame_id
            )
            outputs += self._revolution(header, passage)
        return outputs

    def _refusal(self, message: TyreSignals, stamp: int, voltages: int, accelerations: int) -> str:
        if message.wheel != self.wheel:
            return f"wheel '{message.wheel}' where '{self.wheel}' is expected"
        if stamp == self._last_stamp:
            return "repeated stamp"
        if voltages == 0 or voltages != accelerations:
            return f"{voltages} encoder and {accelerations} acceleration samples"
        if not abs(message.sample_rate - self._p.sample_rate) < 1e-3 * self._p.sample_rate:
            return f"sample rate {message.sample_rate} Hz where parameter 'sample_rate' is {self._p.sample_rate}"
        return ""

    def _revolution(self, header: Header, passage: Passage) -> list[Output]:
        was_changed = self._correction.pressure_changed
        self._patch = self._correction.update(passage)
        if self._correction.pressure_changed and not was_changed:
            self._report("warning", f"{self.wheel}: contact patch length differs at constant speed: pressure changed?")
        self._forces = forces(
            self._patch,
            self._tyre,
            self._wheel_calibration,
            self._correction.zero_speed,
            restore_steady=self._p.restore_steady_force,
        )
        outputs: list[Output] = [
            (f"{self.wheel}/contact_patch", messages.contact_patch(header, self.wheel, self._patch, self._tyre)),
            (f"{self.wheel}/tyre_force", messages.tyre_force(header, self.wheel, self._forces)),
        ]
        if self._p.publish_wrench and self._forces.reason is ForceReason.OK:
            outputs.append((f"{self.wheel}/tyre_wrench", messages.tyre_wrench(header, self._forces)))
        return outputs

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Note silence for diagnostics."""
        age = ages.get(self._topic, 0.0)
        self._silent = f"{self._topic}: no message for {age:.2f} s" if age > _SILENT_AFTER else ""
        return []

    def health(self) -> Health:
        """State for diagnostics."""
        patch, correction = self._patch, self._correction
        values = {
            "tooth table": "known" if self._tracker.wheel.table is not None else "learning",
            "wheel angle": "known" if self._tracker.wheel.known else "unknown",
            "zero speed [m/s]": f"{correction.zero_speed:.2f}",
            "length scale": f"{correction.length_scale:.4f}",
            "revolution": "0" if patch is None else str(patch.passage.revolution),
            "fx [N]": "nan" if self._forces is None else f"{self._forces.fx:.0f}",
            "fz [N]": "nan" if self._forces is None else f"{self._forces.fz:.0f}",
        }
        if self._silent:
            return Health(self.wheel, Level.ERROR, self._silent, values)
        if patch is None:
            return Health(self.wheel, Level.WARN, "no revolution seen yet", values)
        if patch.reason is not PatchReason.OK:
            return Health(self.wheel, Level.WARN, messages.PATCH_TEXTS[patch.reason], values)
        if correction.pressure_changed:
            return Health(self.wheel, Level.WARN, "pressure changed: re-zero the length", values)
        return Health(self.wheel, Level.OK, "ok", values)


def build(parameters: SmartTyreParameters, report: Report = silent) -> list[TyreProcessor]:
    """Make the processors of all wheels.

    Raises:
        ValueError: the calibration file is missing, damaged, or does not fit the parameters.
    """
    calibration = None
    if parameters.calibration_file:
        try:
            calibration = Calibration.load(Path(parameters.calibration_file))
        except OSError as problem:
            raise ValueError(f"parameter 'calibration_file': {problem}") from problem
    return [TyreProcessor(wheel, parameters, calibration, report) for wheel in parameters.wheels]
