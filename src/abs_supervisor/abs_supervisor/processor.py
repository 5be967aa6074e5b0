"""<wheel>/friction_slope and the driver's demand in, <wheel>/abs_supervisor and <wheel>/brake_command out."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

from friction_msgs.msg import BrakeCommand, BrakeDemand, FrictionSlope, SupervisorState, WheelSlip
from sensor_msgs.msg import FluidPressure

from abs_supervisor.braking import TorqueWithHysteresis
from abs_supervisor.braking_log import BrakingLog
from abs_supervisor.fsm import COMMANDS
from abs_supervisor.input_watch import InputWatch, Loss
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
_QUIET = (Reason.OK, Reason.LOW_SPEED)
"""Reasons that belong to ordinary driving."""
_BROKEN = (Reason.NO_SLOPE, Reason.NO_DEMAND, Reason.INVALID_SLOPE, Reason.NO_WHEEL_SPEED, Reason.NO_PRESSURE)
"""Reasons that bring the fail-safe."""
_SLOPE_LOW_SPEED = int(FrictionSlope.LOW_SPEED)
"""Copy of a message constant: a message class looks its constants up in Python, here at every sample."""
_COUNTER_END = 2**32
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
        self._input_watch: InputWatch | None = None
        if not parameters.shadow and parameters.real_time:
            self._input_watch = InputWatch(vehicle, wheel, self._demand, self._slope)
        self.sensors: Mapping[str, type] = {} if by_demand else {self._demand: FluidPressure}
        if self._input_watch is not None:
            self.sensors = self._input_watch.sensors
        self.estimates: Mapping[str, type] = {self._slope: FrictionSlope, f"{wheel}/slip": WheelSlip}
        if by_demand:
            self.estimates = {**self.estimates, self._demand: BrakeDemand}
        self.outputs: Mapping[str, type] = {f"{wheel}/abs_supervisor": SupervisorState}
        if not parameters.shadow:
            self.outputs = {**self.outputs, f"{wheel}/brake_command": BrakeCommand}
        primary = Primary(self._slope, wheel, report, silent_after=parameters.stale_after)
        super().__init__(wheel, primary, [AlignedInput(self._demand)], parameters.deadline)
        self._supervisor = Supervisor(parameters.thresholds, parameters.tolerance)
        self._log = BrakingLog(wheel, report)
        self._hysteresis = TorqueWithHysteresis(parameters.braking_torque, parameters.pressure)
        self._counter = 0
        self._commanded = False
        self._forget()

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message; return the resulting outputs."""
        if self._input_watch is not None:
            self._input_watch.note(topic, message)
        return super().process(topic, message)

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Fail safe when an input is lost, and repeat the command where the node commands in real time.

        Elsewhere only a silent friction_slope is seen by the clock, a silent demand in message time.
        """
        super().watch(ages, now)
        if self._input_watch is None:
            silence = self._primary.silence
            return self._fail((Reason.NO_SLOPE, f"{self._slope}: silent"), silence) if silence else []
        loss = self._input_watch.poll(ages, now)
        outputs = self._fail(loss, loss[1]) if loss is not None else []
        if not outputs and self._stamp != 0 and self._input_watch.wants_heartbeat(ages, self._commanded):
            outputs = [self._command_message()]
        self._commanded = False
        return outputs

    def _fail(self, loss: Loss, said: str) -> list[Output]:
        """Go to S0 because of a loss; return the outputs if that is a transition."""
        self._reason, self._text = loss
        if self._stamp == 0 or not self._supervisor.fail(self._stamp):
            return []
        self._log.note(self._supervisor, self._stamp, said)
        return self._outputs()

    def _payload(self, message: FrictionSlope) -> FrictionSlope:
        return message

    def _take(self, topic: str, message: Any) -> str | None:
        if topic != self._demand:
            return None  # the watch of the inputs has noted it
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
        loss = None if self._input_watch is None else self._input_watch.loss
        if loss is not None and self._input_watch is not None and self._input_watch.is_old(sample.stamp):
            return []
        self._stamp, self._indicator = sample.stamp, slope.indicator
        torque = self._torque_at(sample)
        self._reason, self._text = self._judge(sample, torque)
        self._torque = nan if torque is None else torque
        if loss is not None:
            return self._fail(loss, loss[1]) or self._outputs()
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
        state = new_message(SupervisorState)
        state.header = header
        state.wheel = self._wheel
        state.state = int(machine.state)
        state.previous_state = int(machine.previous_state)
        state.cause = int(machine.cause)
        state.transition_stamp = from_nanoseconds(machine.transition_stamp)
        state.indicator = self._indicator
        state.demand_torque = self._torque
        state.shadow = self._p.shadow
        state.command = int(COMMANDS[machine.state])
        state.release = SupervisorState.RELEASE_NOT_WANTED
        state.cap = SupervisorState.CAP_NONE
        state.slip = state.release_slip = state.wheel_deceleration = state.release_deceleration = nan
        state.unchecked = ""
        state.refused_releases = state.caps = 0
        state.transitions = counts.transitions
        state.instabilities = counts.instabilities
        state.recoveries = counts.recoveries
        state.release_timeouts = counts.release_timeouts
        state.fail_safes = counts.fail_safes
        set_reason(state, self._wheel, self._reason, self._text)
        outputs: list[Output] = [(f"{self._wheel}/abs_supervisor", state)]
        if not self._p.shadow:
            outputs.append(self._command_message())
        return outputs

    def _command_message(self) -> Output:
        """Return the command that is in force, once more: a heartbeat."""
        self._commanded = True
        self._counter = (self._counter + 1) % _COUNTER_END
        command = new_message(BrakeCommand)
        command.header = header_at(self._stamp, self._wheel)
        command.wheel = self._wheel
        command.command = int(COMMANDS[self._supervisor.state])
        command.counter = self._counter
        command.valid_for = self._p.valid_for
        return f"{self._wheel}/brake_command", command


def build(parameters: SupervisorParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one per wheel."""
    return [WheelProcessor(wheel, vehicle, parameters, report) for wheel in vehicle.wheel_names]
