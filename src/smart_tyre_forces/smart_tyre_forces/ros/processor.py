"""<wheel>/tyre_signals in, <wheel>/contact_patch and <wheel>/tyre_force out, once per revolution."""

from collections import deque
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from friction_msgs.msg import ContactPatch, TyreForce, TyreSignals
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import FluidPressure, Imu
from std_msgs.msg import Header

from friction_runtime.aligned_processor import Primary
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_runtime.processor import Health, Level, Output, Report, level_of, silent
from friction_runtime.wheel_inputs import BrakeTorque
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.car_reference import Reference
from smart_tyre_forces.correction import Patch, PatchCorrection
from smart_tyre_forces.forces import Forces, forces, steady_force
from smart_tyre_forces.front_template import FrontTemplate, TemplateFit
from smart_tyre_forces.gain_watch import GainWatch
from smart_tyre_forces.late_signal import DELAY, LateSignal
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.patch_tracker import Passage, PatchTracker
from smart_tyre_forces.ros import messages
from smart_tyre_forces.tooth_table import ToothTable
from smart_tyre_forces.tyre_comparison import TyreComparison
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION, LATEST_STAMP, NEW_RUN
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

_QUIET = (Reason.OK, Reason.NOT_READY, Reason.SPEED_RANGE, Reason.REVERSAL)
"""Reasons that belong to ordinary driving."""

_ACCELERATION = "imu/data"
_LONGEST_STEP = 60.0
"""Longest time between revolutions that counts as such [s]."""
_LAST_SAMPLE = 2**52
"""Last index of a sample: the time of a front within a sample is still resolved there."""


class TyreProcessor:
    """Layer 2 of smart_tyre_forces: one wheel."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        parameters: SmartTyreParameters,
        calibration: Calibration | None,
        report: Report = silent,
        comparison: TyreComparison | None = None,
    ) -> None:
        """Build for one wheel of a car; a wheel that is not in the calibration gives raw contact patches.

        Raises:
            ValueError: the calibration is for another encoder, or lacks the template that the parameters choose.
        """
        self._wheel = vehicle.wheel(wheel)
        self._topic = f"{wheel}/tyre_signals"
        self.estimates: Mapping[str, type] = {self._topic: TyreSignals}
        self.outputs: Mapping[str, type] = {f"{wheel}/contact_patch": ContactPatch, f"{wheel}/tyre_force": TyreForce}
        if parameters.publish_wrench:
            self.outputs = {**self.outputs, f"{wheel}/tyre_wrench": WrenchStamped}
        self._p = parameters
        self._report = report
        self._primary = Primary(self._topic, wheel, report, optional=True)
        self._came = False
        self._template = _template(parameters, calibration)
        self._wheel_calibration = None if calibration is None else calibration.wheels.get(wheel)
        self._tyre = None if calibration is None or self._wheel_calibration is None else calibration.tyre
        brakes = () if self._tyre is None else ((BrakeTorque(vehicle, name), name) for name in vehicle.wheel_names)
        self._brakes = {brake.topic: (brake, name) for brake, name in brakes}
        self.sensors: Mapping[str, type] = dict.fromkeys(self._brakes, FluidPressure)
        if self._tyre is not None:
            self.sensors = {_ACCELERATION: Imu, **self.sensors}
        self.optional = (self._topic, *self.sensors)
        self._accelerometer = vehicle.accelerometer
        self._reference = Reference(vehicle, self._wheel)
        self._comparison = TyreComparison() if comparison is None else comparison
        self._table = None
        if self._wheel_calibration is not None:
            self._table = ToothTable(np.asarray(self._wheel_calibration.tooth_table))
            if len(self._table) != 2 * self._wheel.encoder_teeth:
                raise ValueError(
                    f"calibration file {parameters.calibration_file}: wheel '{wheel}' was calibrated with "
                    f"{len(self._table) // 2} teeth, the vehicle file has {self._wheel.encoder_teeth}"
                )
        self.reset()

    def reset(self) -> None:
        """Start again, as after construction."""
        refiner = TemplateFit(self._template) if self._template is not None else None
        self._tracker = PatchTracker(self._wheel, self._p.tracker, self._table, refiner)
        self._correction = PatchCorrection(self._tyre, self._wheel.radius, self._p.tracker.sample_rate, self._p.zero)
        self._accelerations = LateSignal()
        self._torques = {wheel: LateSignal() for _, wheel in self._brakes.values()}
        self._watch_again()
        self._last_stamp: int | None = None
        self._patch: Patch | None = None
        self._forces: Forces | None = None

    def _watch_again(self) -> None:
        """Watch the gains as a tyre's that is new."""
        self._gains = None if self._tyre is None else GainWatch(self._tyre, self._reference)
        self._unlearned: deque[tuple[int, Patch]] = deque()
        self._learned = 0
        self._zero_speed = np.nan

    def request_shift_zero(self) -> None:
        """Set the shift to zero at the next stretch of constant speed."""
        self._correction.request_shift_zero()

    def request_length_zero(self) -> None:
        """Set the length to nominal at the next stretch of constant speed, after a change of pressure."""
        self._correction.request_length_zero()
        self._watch_again()

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one block, or a sensor of the car; return the outputs for the revolutions that it completes."""
        if topic == _ACCELERATION:
            self._note_acceleration(message)
            return []
        if topic in self._brakes:
            self._note_pressure(*self._brakes[topic], message)
            return []
        self._note_first()
        stamp = to_nanoseconds(message.header.stamp)
        voltage = np.asarray(message.encoder_voltage, dtype=np.float32)
        acceleration = np.asarray(message.radial_acceleration, dtype=np.float32)
        refusal = self._refusal(message, stamp, len(voltage), len(acceleration))
        if refusal:
            self._primary.refuse(f"{topic}: {refusal}")
            return []
        if self._last_stamp is not None and stamp < self._last_stamp:
            self._primary.jumped_back()
            self.reset()
        self._last_stamp = stamp
        outputs: list[Output] = []
        for passage in self._tracker.push(int(message.first_sample), voltage, acceleration):
            seconds = (passage.time - message.first_sample) / self._p.tracker.sample_rate
            header = Header(
                stamp=from_nanoseconds(stamp + round(seconds * NANOSECONDS)), frame_id=message.header.frame_id
            )
            outputs += self._revolution(header, passage)
        return outputs

    def _note_acceleration(self, message: Imu) -> None:
        value = self._accelerometer.forward(message.linear_acceleration)
        stamp = to_nanoseconds(message.header.stamp)
        if isfinite(value) and abs(value) < HIGHEST_ACCELERATION and 0 < stamp <= LATEST_STAMP:
            self._accelerations.take(stamp, value)

    def _note_pressure(self, brake: BrakeTorque, wheel: str, message: FluidPressure) -> None:
        read = brake.read(message)
        if not isinstance(read, str) and 0 < read[0] <= LATEST_STAMP:
            self._torques[wheel].take(*read)

    def _note_first(self) -> None:
        """Report what is missing once there are signals: a wheel without any is not a smart tyre, which is no fault."""
        if not self._came and self._p.calibration_file and self._wheel_calibration is None:
            self._report(
                "warning",
                f"calibration file {self._p.calibration_file}: no wheel '{self._wheel.name}': raw contact patches only",
            )
        self._came = True

    def _refusal(self, message: TyreSignals, stamp: int, voltages: int, accelerations: int) -> str:
        if message.wheel != self._wheel.name:
            return f"wheel \"{message.wheel}\" where '{self._wheel.name}' is expected"
        if not 0 < stamp <= LATEST_STAMP - voltages / self._p.tracker.sample_rate * NANOSECONDS:
            return "stamp is zero" if stamp <= 0 else "stamp is out of range"
        if stamp == self._last_stamp:
            return "stamp repeats"
        if self._last_stamp is not None and 0 < self._last_stamp - stamp < NEW_RUN:
            return "late block"
        if voltages == 0 or voltages != accelerations:
            return f"{voltages} encoder and {accelerations} acceleration samples"
        if message.first_sample > _LAST_SAMPLE:
            return f"first_sample {message.first_sample} is beyond {_LAST_SAMPLE}"
        rate = self._p.tracker.sample_rate
        if not abs(message.sample_rate - rate) < 1e-3 * rate:
            return f"sample rate {message.sample_rate} Hz where parameter 'tracker.sample_rate' is {rate}"
        return ""

    def _revolution(self, header: Header, passage: Passage) -> list[Output]:
        was_changed = self._correction.pressure_changed
        self._patch = self._correction.update(passage)
        if self._correction.pressure_changed and not was_changed:
            self._report(
                "warning", f"{self._wheel.name}: contact patch length differs at constant speed: pressure changed?"
            )
        if self._gains is not None:
            self._learn(to_nanoseconds(header.stamp), self._patch, self._gains)
        self._forces = forces(
            self._patch,
            self._tyre,
            self._wheel_calibration,
            self._correction.zero_speed,
            restore_steady=self._p.restore_steady_force,
            gain=None if self._gains is None else self._gains.gain,
        )
        wheel = self._wheel.name
        outputs: list[Output] = [
            (f"{wheel}/contact_patch", messages.contact_patch(header, wheel, self._patch, self._tyre)),
            (f"{wheel}/tyre_force", messages.tyre_force(header, wheel, self._forces)),
        ]
        if self._p.publish_wrench and self._forces.reason is Reason.OK:
            outputs.append((f"{wheel}/tyre_wrench", messages.tyre_wrench(header, self._forces)))
        return outputs

    @property
    def delay_change(self) -> float:
        """By how much the delay of the acceleration in the tyre has changed [s], 0 where that is not significant."""
        return 0.0 if self._gains is None else self._gains.delay_change

    def _learn(self, stamp: int, patch: Patch, gains: GainWatch) -> None:
        """Learn from the revolutions DELAY ago: what comes out does not depend on which input arrived first."""
        zero_speed = self._correction.zero_speed
        if patch.reason is not Reason.OK or self._tyre is None or self._wheel_calibration is None:
            return
        if zero_speed != self._zero_speed:
            self._watch_again()
            self._zero_speed = zero_speed
        seconds = 0.5 * patch.length_raw / patch.passage.wheel_speed
        self._unlearned.append((stamp - round(seconds * NANOSECONDS), patch))
        while stamp - self._unlearned[0][0] > DELAY * NANOSECONDS:
            when, past = self._unlearned.popleft()
            acceleration = self._accelerations.at(when)
            if acceleration is None or self._gains is None:
                continue
            steady = steady_force(self._tyre, self._wheel_calibration, past.speed, zero_speed)
            known = {wheel: signal.at(when) for wheel, signal in self._torques.items()}
            torques = {wheel: torque for wheel, torque in known.items() if torque is not None}
            share = None
            if self._reference.has_share:
                share = self._reference.share(past.speed, acceleration, torques)
            since = min(max(when - self._learned, 0) / NANOSECONDS, _LONGEST_STEP)
            self._gains.see(past, acceleration, share, steady, zero_speed, since)
            self._learned = when
            self._comparison.gains[self._wheel.name] = self._gains.gain

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Note silence for diagnostics, once signals have been received."""
        self._primary.watch(ages)
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
        if self._tyre is not None:
            for name, force in (("fx", self._tyre.shift_map), ("fz", self._tyre.length_map)):
                values[f"{name} valid [N]"] = "{:.0f} to {:.0f}".format(*force.reach)
        level, text = self._state()
        return Health(self._wheel.name, level, text, values)

    def _state(self) -> tuple[Level, str]:
        if self._primary.silence:
            return Level.ERROR, self._primary.silence
        if not self._came:
            return Level.OK, "no tyre signals"
        if self._patch is None:
            return Level.OK, "no revolution seen yet"
        if verdict := self._comparison.verdict(self._wheel.name):
            return Level.WARN, verdict
        if change := self.delay_change:
            return Level.WARN, f"delay of the acceleration in the tyre changed by {1e3 * change:+.2f} ms"
        level, text = level_of(self._patch.reason, _QUIET, broken=()), self._patch.text
        if level is Level.OK and self._correction.pressure_changed:
            return Level.WARN, "pressure changed: re-zero the length"
        return level, text or "ok"


def build(parameters: SmartTyreParameters, vehicle: Vehicle, report: Report = silent) -> list[TyreProcessor]:
    """Make the processors: one per wheel.

    Raises:
        ValueError: the calibration file is missing or damaged, has no wheel of the car, or does not fit the parameters.
    """
    calibration = None
    if parameters.calibration_file:
        try:
            calibration = Calibration.load(Path(parameters.calibration_file))
        except OSError as problem:
            raise ValueError(f"parameter 'calibration_file': {problem}") from problem
        if not set(vehicle.wheel_names) & set(calibration.wheels):
            raise ValueError(
                f"calibration file {parameters.calibration_file}: has {', '.join(calibration.wheels)}, "
                f"no wheel of the car: {', '.join(vehicle.wheel_names)}"
            )
    comparison = TyreComparison()
    return [TyreProcessor(wheel, vehicle, parameters, calibration, report, comparison) for wheel in vehicle.wheel_names]


def _template(parameters: SmartTyreParameters, calibration: Calibration | None) -> FrontTemplate | None:
    """Return the template to find the fronts by, None where they are crossings.

    Raises:
        ValueError: the parameters choose a template, and the calibration has none.
    """
    if parameters.front_method != "template":
        return None
    if calibration is None or calibration.template is None:
        raise ValueError(f"calibration file {parameters.calibration_file}: no template")
    return calibration.template
