"""<wheel>/friction_slope and the driver's demand in, <wheel>/abs_supervisor and <wheel>/brake_command out."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import BrakeCommand, BrakeDemand, FrictionSlope, SupervisorState
from sensor_msgs.msg import FluidPressure

from abs_supervisor.braking import TorqueWithHysteresis
from abs_supervisor.braking_log import BrakingLog
from abs_supervisor.fsm import COMMANDS
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.supervisor import Evidence, Reason, Supervisor
from friction_runtime.aligned_processor import AlignedProcessor
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.brake_torque import BrakeTorque
from friction_runtime.new_message import new_message
from friction_runtime.primary import Primary
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.reason_text import of_topic, set_reason, without_wheel
from friction_runtime.stamps import from_nanoseconds, header_at, to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle

BRAKE_DEMAND = "brake_demand"
_VALID_FOR = 0.1
"""[s]"""
_QUIET = (Reason.OK, Reason.LOW_SPEED)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_SLOPE, Reason.NO_DEMAND, Reason.INVALID_SLOPE)
"""Reasons that bring the fail-safe."""
_SLOPE_LOW_SPEED = int(FrictionSlope.LOW_SPEED)
"""Copy of a message constant: a message class looks its constants up in Python, here at every sample."""
_ALIVE = (FrictionSlope.OK, FrictionSlope.NOT_BRAKING, FrictionSlope.NO_EXCITATION, FrictionSlope.LOW_SPEED)
"""Reasons of friction_slope with which the machine can go on."""


class WheelProcessor(AlignedProcessor[FrictionSlope]):
    """Layer 2 of abs_supervisor: fires on <wheel>/friction_slope."""

    def __init__(self, wheel: str, vehicle: Vehicle, parameters: SupervisorParameters, report: Report = silent) -> None:
        """Build for one wheel of a car; `report` is the log function."""
        self._wheel, self._p = wheel, parameters
        self._brake_torque = BrakeTorque(vehicle, wheel)
        self._slope = f"{wheel}/friction_slope"
        by_demand = parameters.braking_source == "demand"
        self._demand = BRAKE_DEMAND if by_demand else self._brake_torque.topic
        self.sensors: Mapping[str, type] = {} if by_demand else {self._demand: FluidPressure}
        self.estimates: Mapping[str, type] = {self._slope: FrictionSlope}
        if by_demand:
            self.estimates = {**self.estimates, self._demand: BrakeDemand}
        self.outputs: Mapping[str, type] = {f"{wheel}/abs_supervisor": SupervisorState}
        if not parameters.shadow:
            self.outputs = {**self.outputs, f"{wheel}/brake_command": BrakeCommand}
        self.commands: Mapping[str, float] = {} if parameters.shadow else {f"{wheel}/brake_command": _VALID_FOR}
        self._counter = 0
        primary = Primary(self._slope, wheel, report, silent_after=parameters.stale_after)
        super().__init__(wheel, primary, [AlignedInput(self._demand)], parameters.deadline)
        self._supervisor = Supervisor(parameters.thresholds, parameters.tolerance)
        self._log = BrakingLog(wheel, report)
        self._hysteresis = TorqueWithHysteresis(parameters.braking_torque, parameters.pressure)
        self._forget()

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Fail safe when friction_slope has fallen silent; a silent demand is seen in message time."""
        super().watch(ages)
        silence = self._primary.silence
        if self._stamp == 0 or not silence:
            return []
        self._reason, self._text = Reason.NO_SLOPE, f"{self._slope}: silent"
        if self._supervisor.fail(self._stamp):
            self._log.note(self._supervisor, self._stamp, silence)
            return self._outputs()
        return []

    def _payload(self, message: FrictionSlope) -> FrictionSlope:
        return message

    def _take(self, topic: str, message: Any) -> str | None:
        return self._offer_demand(topic, to_nanoseconds(message.header.stamp), message)

    def _forget(self) -> None:
        self._supervisor.reset()
        self._log.reset()
        self._hysteresis.reset()
        self._held: tuple[int, float] | None = None
        self._stamp = 0
        self._reason, self._text = Reason.NO_SLOPE, f"{self._slope}: no message yet"
        self._indicator = self._torque = nan

    def _start_again(self, stamp: int) -> None:
        self._hysteresis.reset()
        if self._supervisor.restart(stamp):
            self._log.note(self._supervisor, self._stamp, "")

    def _state(self) -> tuple[Level, str]:
        return level_of(self._reason, _QUIET, _BROKEN), self._text or self._supervisor.state.name

    def _values(self) -> dict[str, str]:
        machine, counts = self._supervisor, self._supervisor.counts
        return {
            "state": machine.state.name,
            "cause of the last transition": machine.cause.name.lower(),
            "transitions": str(counts.transitions),
            "instabilities": str(counts.instabilities),
            "recoveries": str(counts.recoveries),
            "release time-outs": str(counts.release_timeouts),
            "fail-safes": str(counts.fail_safes),
            "shadow": str(self._p.shadow).lower(),
        }

    def _offer_demand(self, topic: str, stamp: int, message: Any) -> str | None:
        if topic == BRAKE_DEMAND:
            if message.wheel not in ("", self._wheel):
                return None
            torque = self._brake_torque.torque(topic, message.pressure)
            if isinstance(torque, str):
                return torque
        else:
            read = self._brake_torque.read(message)
            if isinstance(read, str):
                return read
            stamp, torque = read
        refusal = self._aligner.offer(topic, stamp, (torque,))
        if refusal is None:
            self._held = (stamp, torque)
        return refusal

    def _fire(self, sample: AlignedSample[FrictionSlope]) -> list[Output]:
        slope = sample.payload
        self._stamp, self._indicator = sample.stamp, slope.indicator
        torque = self._torque_at(sample)
        self._reason, self._text = self._judge(sample, torque)
        self._torque = nan if torque is None else torque
        usable = self._reason in _QUIET
        evidence = Evidence(
            h=slope.h,
            indicator=slope.indicator,
            usable=usable,
            slow=self._reason is Reason.LOW_SPEED,
            braking=torque is not None and self._brakes(sample.stamp, torque),
        )
        if self._supervisor.update(sample.stamp, evidence):
            self._log.note(self._supervisor, sample.stamp, self._text)
        return self._outputs()

    def _torque_at(self, sample: AlignedSample[FrictionSlope]) -> float | None:
        """Return the torque that the driver demands [N m]; None where it is not known."""
        if self._demand in sample.values:
            return sample.values[self._demand][0]
        if self._held is not None and 0 <= sample.stamp - self._held[0] <= self._p.demand_timeout * NANOSECONDS:
            return self._held[1]
        return None

    def _brakes(self, stamp: int, torque: float) -> bool:
        if self._p.braking_source == "demand":
            return torque >= self._p.braking_torque
        return self._hysteresis.update(stamp, torque)

    def _judge(self, sample: AlignedSample[FrictionSlope], torque: float | None) -> tuple[Reason, str]:
        """Return the reason why the machine may not act on this sample, or OK, and its text."""
        slope = sample.payload
        if torque is None:
            return Reason.NO_DEMAND, sample.missing[self._demand]
        if slope.reason == _SLOPE_LOW_SPEED:
            return Reason.LOW_SPEED, without_wheel(self._wheel, slope.reason_text)
        if slope.reason not in _ALIVE and not isfinite(slope.indicator):
            return Reason.INVALID_SLOPE, of_topic(self._slope, slope.reason_text)
        return Reason.OK, ""

    def _outputs(self) -> list[Output]:
        machine, counts = self._supervisor, self._supervisor.counts
        header = header_at(self._stamp, self._wheel)
        state = SupervisorState()
        state.header = header
        state.wheel = self._wheel
        state.state = int(machine.state)
        state.previous_state = int(machine.previous_state)
        state.cause = int(machine.cause)
        state.transition_stamp = from_nanoseconds(machine.transition_stamp)
        state.indicator = self._indicator
        state.demand_torque = self._torque
        state.shadow = self._p.shadow
        state.transitions = counts.transitions
        state.instabilities = counts.instabilities
        state.recoveries = counts.recoveries
        state.release_timeouts = counts.release_timeouts
        state.fail_safes = counts.fail_safes
        set_reason(state, self._wheel, self._reason, self._text)
        outputs: list[Output] = [(f"{self._wheel}/abs_supervisor", state)]
        if not self._p.shadow:
            command = new_message(BrakeCommand)
            command.header = header
            command.wheel = self._wheel
            command.command = int(COMMANDS[machine.state])
            self._counter = (self._counter + 1) % 2**32
            command.counter = self._counter
            command.valid_for = _VALID_FOR
            outputs.append((f"{self._wheel}/brake_command", command))
        return outputs


def build(parameters: SupervisorParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one per wheel."""
    return [WheelProcessor(wheel, vehicle, parameters, report) for wheel in vehicle.wheel_names]
