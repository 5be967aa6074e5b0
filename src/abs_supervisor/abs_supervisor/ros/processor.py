"""<wheel>/slope_vote, the driver's demand and the sensors of a wheel in, state and brake_command out."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any, Final

from friction_msgs.msg import BrakeCommand, BrakeDemand, SlopeVote, SupervisorDebug, SupervisorState
from std_msgs.msg import Header

from abs_supervisor.axle import Axle, axles
from abs_supervisor.parameters import CURVE, SupervisorParameters, TorqueWithHysteresis
from abs_supervisor.ros.input_watch import InputWatch, Loss
from abs_supervisor.ros.reports import BrakingLog, diagnostic_values, state_messages
from abs_supervisor.ros.wheel_inputs import BRAKE_DEMAND, IMU, WheelInputs, curve_report
from abs_supervisor.speed_probe import SpeedProbe
from abs_supervisor.state_machine import COMMANDS, Cause, State, StateMachine
from abs_supervisor.wheel_supervisor import WheelSupervisor
from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.reports import of_topic, without_wheel
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import REAR, Vehicle

_QUIET = (Reason.OK, Reason.LOW_SPEED)
"""Reasons that belong to ordinary driving."""
_MISMATCH = Reason.PRESSURE_MISMATCH
"""The law goes on: no evidence for a release comes from the pressure, so that a wrong one releases no healthy wheel."""
_USABLE = (*_QUIET, _MISMATCH)
"""Reasons with which the law goes on; the others bring the fail-safe."""
_BROKEN = tuple(set(Reason) - set(_USABLE))
_MISSING = (Reason.NO_DEMAND, Reason.NO_PRESSURE, Reason.NO_WHEEL_SPEED, Reason.NO_SLOPE)
_UNMEASURED = (Reason.NOT_BRAKING, Reason.NO_EXCITATION)
"""Reasons of a vote with which the machine goes on although there is no indicator."""
_CURVE_GAP: Final = 0.02
"""[s] curves of a tyre's blocks are further apart; nothing waits for these, as nobody knows when the next one comes."""
_MAY_BE_LOCKED: Final = "speed known from this wheel only; it may be locked, ABS inactive"
_DEGRADED: Final = "degraded: speed of the car from its wheels alone, select-low at the rear"
_SHARED: Final = 3
"""Minimum wheel count for a speed probe."""


class WheelProcessor(AlignedProcessor[SlopeVote]):
    """Layer 2 of abs_supervisor: fires on <wheel>/slope_vote."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        parameters: SupervisorParameters,
        report: Report = silent,
        axle: Axle | None = None,
        probe: SpeedProbe | None = None,
    ) -> None:
        """Build for one wheel of a car.

        Args:
            wheel: its name.
            vehicle: the car.
            parameters: of the node.
            report: the log function.
            axle: with the other wheel of it, where there is one.
            probe: chooses the wheel of the car that shows its speed, where one may.
        """
        self._wheel, self._p = wheel, parameters
        self._state_topic, self._debug_topic = f"{wheel}/abs_supervisor", f"{wheel}/abs_supervisor_debug"
        self._command_topic = f"{wheel}/brake_command"
        self._inputs = inputs = WheelInputs(wheel, vehicle, report, fine=parameters.law == CURVE)
        self._vote = f"{wheel}/slope_vote"
        by_demand = parameters.braking_source == "demand"
        self._demand = BRAKE_DEMAND if by_demand else inputs.pressure
        in_real_time = not parameters.shadow and parameters.real_time
        self._input_watch = InputWatch(inputs.pressure, self._demand, self._vote) if in_real_time else None
        self.sensors: Mapping[str, type] = inputs.sensors
        self.estimates: Mapping[str, type] = {self._vote: SlopeVote, **inputs.estimates}
        if by_demand:
            self.estimates = {**self.estimates, self._demand: BrakeDemand}
        self.outputs: Mapping[str, type] = {self._state_topic: SupervisorState, self._debug_topic: SupervisorDebug}
        if not parameters.shadow:
            self.outputs = {**self.outputs, self._command_topic: BrakeCommand}
        self.commands: Mapping[str, float] = {self._command_topic: parameters.valid_for} if in_real_time else {}
        primary = Primary(self._vote, wheel, report, silent_after=parameters.stale_after)
        topics = dict.fromkeys((self._demand, inputs.pressure, WHEEL_STATES, inputs.slip))
        aligned = [AlignedInput(topic) for topic in topics]
        if IMU in self.sensors:
            aligned.append(AlignedInput(IMU, optional=True))
        self._waits_for_curve = not in_real_time
        if self._waits_for_curve:
            # Without the clock nothing shows that the curve of a sample has come: it is waited for.
            aligned.append(AlignedInput(inputs.curve, max_gap=_CURVE_GAP, optional=True))
        super().__init__(wheel, primary, aligned, parameters.deadline, optional=(inputs.curve, IMU))
        self._machine = StateMachine(parameters.thresholds, parameters.tolerance)
        self._log = BrakingLog(wheel, report)
        self._report = report
        self._hysteresis = TorqueWithHysteresis(parameters.braking_torque, parameters.pressure)
        self._supervisor = WheelSupervisor(
            wheel,
            vehicle,
            parameters.actuator,
            by_curve=parameters.law == CURVE,
            obeyed=by_demand and not parameters.shadow,
            axle=axle,
            probe=probe,
        )
        self._counter = 0
        self._commanded = False
        self._forget()

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Fail safe when an input is lost, and repeat the command where the node commands in real time.

        Elsewhere only a silent vote is seen by the clock, a silent demand in message time.
        """
        super().watch(ages, now)
        if self._input_watch is None:
            silence = self._primary.silence
            return self._fail((Reason.NO_SLOPE, f"{self._vote}: silent"), silence) if silence else []
        loss = self._input_watch.poll(ages, now)
        outputs = self._fail(loss, loss[1]) if loss is not None else []
        if not outputs and self._stamp != 0 and self._input_watch.wants_heartbeat(ages, self._commanded):
            outputs = [self._heartbeat(header_at(self._stamp, self._wheel))]
        self._commanded = False
        return outputs

    @property
    def acts(self) -> bool:
        """Whether it commands, and the brake is applied: a reset would empty the caps in the middle of a stop."""
        return not self._p.shadow and self._machine.state is not State.S0

    def hand_over(self) -> Sequence[Output]:
        """Return NONE for the newest sample: the brake is the driver's."""
        self._command = Command.NONE
        return [] if self._p.shadow or self._stamp == 0 else [self._heartbeat(header_at(self._stamp, self._wheel))]

    def _fail(self, loss: Loss, text: str) -> list[Output]:
        """Go to S0 because of a loss; return the outputs if that is a transition."""
        self._reason, self._text = loss
        if self._stamp == 0 or not self._machine.fail(self._stamp):
            return []
        self._log.note(self._machine, self._stamp, text)
        self._command = Command.NONE
        return self._outputs()

    def _payload(self, message: SlopeVote) -> SlopeVote:
        self._note(self._vote, message)
        return message

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == BRAKE_DEMAND and message.wheel not in ("", self._wheel):
            return None
        if topic == self._inputs.curve:
            report = curve_report(message)
            counts_from = self._supervisor.curve.put(report) if report.stamp > 0 else 0
            return self._aligner.offer(topic, counts_from, ()) if self._waits_for_curve else None
        read = self._inputs.read(topic, message)
        if isinstance(read, str):
            return read
        stamp, values = read
        if self._inputs.knows_wheel(topic, values):
            self._note(topic, message)
        refusal = self._aligner.offer(topic, stamp, values)
        if refusal is None and topic == self._demand:
            self._held = (stamp, values[0])
        return refusal

    def _note(self, topic: str, message: Any) -> None:
        """Note for the watch of the inputs, if there is one, that the content of a message is good."""
        if self._input_watch is not None:
            self._input_watch.note(topic, to_nanoseconds(message.header.stamp))

    def _forget(self) -> None:
        self._machine.reset()
        self._supervisor.reset()
        self._inputs.reset()
        self._log.reset()
        self._hysteresis.reset()
        self._held = (0, nan)
        self._stamp = 0
        self._reason, self._text = Reason.NO_SLOPE, f"{self._vote}: no message yet"
        self._warned: Reason | None = None
        self._indicator = self._torque = nan
        self._command = Command.NONE

    def _start_again(self, stamp: int) -> None:
        self._hysteresis.reset()
        self._supervisor.restart()
        self._inputs.reset()
        if self._machine.restart(stamp):
            self._log.note(self._machine, self._stamp, "")

    def _state(self) -> tuple[Level, str]:
        level = level_of(self._reason, _QUIET, _BROKEN)
        if level is Level.OK and self._supervisor.degraded:
            return Level.WARN, _DEGRADED
        if self._p.shadow and self._reason in _MISSING:
            level = Level.WARN  # beside a stack that has no such topic nothing is broken
        if self._reason is Reason.LOW_SPEED and self._gives_up():
            level = Level.WARN
        return level, self._text or self._machine.state.name

    def _values(self) -> dict[str, str]:
        return {**diagnostic_values(self._machine, self._supervisor), "shadow": str(self._p.shadow).lower()}

    def _fire(self, sample: AlignedSample[SlopeVote]) -> list[Output]:
        vote = sample.payload
        loss = None if self._input_watch is None else self._input_watch.loss
        if loss is not None and self._input_watch is not None and self._input_watch.is_old(sample.stamp):
            return []
        self._stamp, self._indicator = sample.stamp, vote.indicator
        self._torque = self._torque_at(sample)
        supervisor = self._supervisor
        demand = self._torque if self._demand == BRAKE_DEMAND else nan
        supervisor.observe(sample.stamp, self._inputs.observe(sample, demand))
        if loss is not None:
            self._command = supervisor.decide(Command.NONE)
            return self._fail(loss, loss[1]) or self._outputs()
        self._reason, self._text = self._judge(sample)
        if self._p.shadow and self._reason in _MISSING and self._reason is not self._warned:
            self._warned = self._reason
            self._report("warning", f"{self._wheel}: {self._text}")
        h, indicator = vote.h, vote.indicator if vote.validity.valid else nan
        if vote.validity.reason == Reason.LOW_SPEED and supervisor.car.slides:
            h, indicator = nan, self._p.thresholds.h_instability
        braking = isfinite(self._torque) and self._brakes(sample.stamp, self._torque)
        usable, slow = self._reason in _USABLE, self._reason is Reason.LOW_SPEED
        if self._machine.update(sample.stamp, h, indicator, braking, usable, slow):
            self._log.note(self._machine, sample.stamp, self._text)
        asked = COMMANDS[self._machine.state]
        if supervisor.by_curve and slow and braking and isfinite(supervisor.measured.car_speed):
            # The machine has ended; the intervention gives the brake back, and slip control goes on until it has.
            asked = Command.INCREASE
        self._command = supervisor.decide(asked)
        return self._outputs()

    def _torque_at(self, sample: AlignedSample[SlopeVote]) -> float:
        """Return the torque that the driver demands [N m]; NaN where it is not known."""
        if self._demand in sample.values:
            return sample.values[self._demand][0]
        stamp, torque = self._held
        return torque if 0 <= sample.stamp - stamp <= self._p.demand_timeout * NANOSECONDS else nan

    def _brakes(self, stamp: int, torque: float) -> bool:
        if self._p.braking_source == "demand":
            return torque >= self._p.braking_torque
        return self._hysteresis.update(stamp, torque)

    def _judge(self, sample: AlignedSample[SlopeVote]) -> tuple[Reason, str]:
        """Return the reason why the machine may not act on this sample, or OK, and its text."""
        vote, supervisor = sample.payload, self._supervisor
        measured = supervisor.measured
        if not isfinite(self._torque):
            return Reason.NO_DEMAND, sample.missing[self._demand]
        if not isfinite(measured.wheel_speed):
            return Reason.NO_WHEEL_SPEED, sample.missing.get(WHEEL_STATES, f"{WHEEL_STATES}: no speed of this wheel")
        if not isfinite(measured.torque):
            return Reason.NO_PRESSURE, sample.missing[self._inputs.pressure]
        if supervisor.plausibility.text:
            return Reason.WHEEL_SENSOR, supervisor.plausibility.text
        reason, text = vote.validity.reason, vote.validity.text
        slow = reason == Reason.LOW_SPEED
        if slow and not supervisor.car.slides:
            text = without_wheel(self._wheel, text)
            return Reason.LOW_SPEED, f"{text}, by {_MAY_BE_LOCKED}" if self._gives_up() else text
        alive = slow or reason in _UNMEASURED or vote.validity.valid
        # With an indicator, a vote that is not ready has not passed a threshold yet; without, its window is not full.
        if not alive and not (reason == Reason.NOT_READY and isfinite(vote.indicator)):
            return Reason.INVALID_SLOPE, of_topic(self._vote, text)
        if supervisor.brake.text:
            return _MISMATCH, f"{self._inputs.pressure}: {supervisor.brake.text}"
        return Reason.OK, ""

    def _gives_up(self) -> bool:
        """Whether the ABS ends by the speed of a wheel that a lock would bring down as well."""
        machine = self._machine
        acted = machine.state is not State.S0 or machine.cause is Cause.LOW_SPEED
        return acted and self._supervisor.car.may_be_locked

    def _outputs(self) -> list[Output]:
        header = header_at(self._stamp, self._wheel)
        state, debug = state_messages(header, self._machine, self._supervisor)
        state.command, state.shadow, state.demand_torque = int(self._command), self._p.shadow, self._torque
        state.validity = validity(self._wheel, self._reason, self._text)
        debug.indicator = self._indicator
        outputs: list[Output] = [(self._state_topic, state)]
        if not self._p.shadow:
            outputs.append(self._heartbeat(header))
        return [*outputs, (self._debug_topic, debug)]

    def _heartbeat(self, header: Header) -> Output:
        """Return the command that is in force, once more: a heartbeat."""
        self._commanded = True
        self._counter = (self._counter + 1) % 2**32  # uint32
        command, counter, valid_for = int(self._command), self._counter, self._p.valid_for
        message = BrakeCommand(header=header, wheel=self._wheel, command=command, counter=counter, valid_for=valid_for)
        return self._command_topic, sealed(message)


def build(parameters: SupervisorParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one per wheel."""
    coupled = axles(vehicle, parameters.select_low)
    rear = [wheel.name for wheel in vehicle.wheels if wheel.axle == REAR]
    probes = parameters.speed_probe and parameters.law == CURVE and len(vehicle.wheels) >= _SHARED and rear
    probe = SpeedProbe(rear) if probes else None
    return [
        WheelProcessor(wheel, vehicle, parameters, report, coupled.get(wheel), probe) for wheel in vehicle.wheel_names
    ]
