"""<wheel>/slope_vote, the driver's demand and what the envelope needs in, state and brake_command out."""

from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any, Final

from friction_msgs.msg import BrakeCommand, BrakeDemand, SlopeVote, SupervisorDebug, SupervisorState
from std_msgs.msg import Header

from abs_supervisor.braking import TorqueWithHysteresis
from abs_supervisor.end_of_stop import EndOfStop
from abs_supervisor.fsm import COMMANDS, Cause, State
from abs_supervisor.guard import Guard, Seen
from abs_supervisor.parameters import CURVE, SupervisorParameters
from abs_supervisor.reference_wheel import ReferenceWheel
from abs_supervisor.release_evidence import Release
from abs_supervisor.ros.braking_log import BrakingLog
from abs_supervisor.ros.curve_control import CurveControl, describe
from abs_supervisor.ros.input_watch import InputWatch, Loss
from abs_supervisor.ros.wheel_inputs import WheelInputs
from abs_supervisor.supervisor import Evidence, Supervisor
from abs_supervisor.wheel_pair import WheelPair, wheel_pairs
from friction_runtime.aligned_processor import AlignedProcessor, Primary
from friction_runtime.aligner import AlignedInput, AlignedSample
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import from_nanoseconds, header_at, to_nanoseconds, validity
from friction_runtime.processor import Level, Output, Report, level_of, silent
from friction_runtime.reports import of_topic, without_wheel
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_models.brake_actuator import Command
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import REAR, Vehicle

BRAKE_DEMAND: Final = "brake_demand"
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
_COUNTER_END: Final = 2**32
_SHARED: Final = 3
"""Minimum wheel count for a reference release."""


class WheelProcessor(AlignedProcessor[SlopeVote]):
    """Layer 2 of abs_supervisor: fires on <wheel>/slope_vote."""

    def __init__(
        self,
        wheel: str,
        vehicle: Vehicle,
        parameters: SupervisorParameters,
        report: Report = silent,
        pair: WheelPair | None = None,
        reference: ReferenceWheel | None = None,
    ) -> None:
        """Build for one wheel of a car.

        Args:
            wheel: its name.
            vehicle: the car.
            parameters: of the node.
            report: the log function.
            pair: the wheel and the other one of its axle, where they know of each other.
            reference: chooses the wheel of the car that rolls for a moment, where one may.
        """
        self._wheel, self._p, self._pair, self._reference = wheel, parameters, pair, reference
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
        self._waits_for_curve = not in_real_time
        if self._waits_for_curve:
            # Only the clock tells that the curve a sample speaks of has come: without it, it is waited for.
            aligned.append(AlignedInput(inputs.curve, max_gap=_CURVE_GAP, optional=True))
        super().__init__(wheel, primary, aligned, parameters.deadline, optional=(inputs.curve,))
        self._supervisor = Supervisor(parameters.thresholds, parameters.tolerance)
        self._log = BrakingLog(wheel, report)
        self._report = report
        self._hysteresis = TorqueWithHysteresis(parameters.braking_torque, parameters.pressure)
        obeyed = by_demand and not parameters.shadow
        self._guard = Guard(vehicle.corner(wheel), parameters.tuning.envelope, parameters.actuator, obeyed)
        self._end_of_stop = EndOfStop(vehicle.corner(wheel), parameters.actuator)
        self._curve_control = None
        if parameters.law == CURVE:
            self._curve_control = CurveControl(wheel, vehicle, parameters.actuator, parameters.tuning)
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
        return not self._p.shadow and self._supervisor.state is not State.S0

    def hand_over(self) -> Sequence[Output]:
        """Return NONE for the newest sample: the brake is the driver's."""
        self._command = Command.NONE
        return [] if self._p.shadow or self._stamp == 0 else [self._heartbeat(header_at(self._stamp, self._wheel))]

    def _fail(self, loss: Loss, said: str) -> list[Output]:
        """Go to S0 because of a loss; return the outputs if that is a transition."""
        self._reason, self._text = loss
        if self._stamp == 0 or not self._supervisor.fail(self._stamp):
            return []
        self._log.note(self._supervisor, self._stamp, said)
        self._command = Command.NONE
        return self._outputs()

    def _payload(self, message: SlopeVote) -> SlopeVote:
        self._note(self._vote, message)
        return message

    def _take(self, topic: str, message: Any) -> str | None:
        if topic == BRAKE_DEMAND:
            return self._offer_demand(message)
        if topic == self._inputs.curve:
            if self._curve_control is not None:
                self._curve_control.take(message)
            counts_from = self._inputs.take_curve(message)
            return self._aligner.offer(topic, counts_from, ()) if self._waits_for_curve else None
        read = self._inputs.read(topic, message)
        if isinstance(read, str):
            return read
        stamp, values = read
        if self._inputs.knows_wheel(topic, values):
            self._note(topic, message)
        return self._offer(topic, stamp, values)

    def _note(self, topic: str, message: Any) -> None:
        """Note for the watch of the inputs, if there is one, that the content of a message is good."""
        if self._input_watch is not None:
            self._input_watch.note(topic, to_nanoseconds(message.header.stamp))

    def _forget(self) -> None:
        self._supervisor.reset()
        self._guard.reset()
        self._end_of_stop.reset()
        self._inputs.reset()
        self._log.reset()
        self._hysteresis.reset()
        self._held: tuple[int, float] | None = None
        self._stamp = 0
        self._reason, self._text = Reason.NO_SLOPE, f"{self._vote}: no message yet"
        self._warned: Reason | None = None
        self._indicator = self._torque = nan
        self._seen = Seen(nan, nan, nan)
        self._command = Command.NONE
        if self._curve_control is not None:
            self._curve_control.reset()
        if self._pair is not None:
            self._pair.forget(self._wheel)

    def _start_again(self, stamp: int) -> None:
        self._hysteresis.reset()
        self._guard.restart()
        self._end_of_stop.reset()
        self._inputs.reset()
        if self._curve_control is not None:
            self._curve_control.reset()
        if self._pair is not None:
            self._pair.forget(self._wheel)
        if self._supervisor.restart(stamp):
            self._log.note(self._supervisor, self._stamp, "")

    def _state(self) -> tuple[Level, str]:
        level = level_of(self._reason, _QUIET, _BROKEN)
        if self._p.shadow and self._reason in _MISSING:
            level = Level.WARN  # beside a stack that has no such topic nothing is broken
        if self._reason is Reason.LOW_SPEED and self._gives_up():
            level = Level.WARN
        return level, self._text or self._supervisor.state.name

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
            "refused releases": str(self._guard.envelope.refused),
            "caps": str(self._guard.envelope.caps.count),
            "unchecked": self._guard.unchecked,
            "shadow": str(self._p.shadow).lower(),
        }

    def _offer_demand(self, message: BrakeDemand) -> str | None:
        if message.wheel not in ("", self._wheel):
            return None
        torque = self._inputs.brake.torque(BRAKE_DEMAND, message.pressure)
        if isinstance(torque, str):
            return torque
        self._note(BRAKE_DEMAND, message)
        return self._offer(BRAKE_DEMAND, to_nanoseconds(message.header.stamp), (torque,))

    def _offer(self, topic: str, stamp: int, values: tuple[float, ...]) -> str | None:
        refusal = self._aligner.offer(topic, stamp, values)
        if refusal is None and topic == self._demand:
            self._held = (stamp, values[0])
        return refusal

    def _fire(self, sample: AlignedSample[SlopeVote]) -> list[Output]:
        vote = sample.payload
        loss = None if self._input_watch is None else self._input_watch.loss
        if loss is not None and self._input_watch is not None and self._input_watch.is_old(sample.stamp):
            return []
        self._stamp, self._indicator = sample.stamp, vote.indicator
        torque = self._torque_at(sample)
        self._torque = nan if torque is None else torque
        seen = self._inputs.observe(sample, self._torque if self._demand == BRAKE_DEMAND else nan)
        if isfinite(seen.wheel_speed):
            self._guard.look(sample.stamp, seen)
        self._seen = seen
        if loss is not None:
            if isfinite(seen.wheel_speed):
                self._guard.command(sample.stamp, Command.NONE)
            self._command = Command.NONE
            return self._fail(loss, loss[1]) or self._outputs()
        self._reason, self._text = self._judge(sample, torque)
        if self._p.shadow and self._reason in _MISSING and self._reason is not self._warned:
            self._warned = self._reason
            self._report("warning", f"{self._wheel}: {self._text}")
        h, indicator = vote.h, vote.indicator if vote.validity.valid else nan
        if vote.validity.reason == Reason.LOW_SPEED and self._guard.slides:
            h, indicator = nan, self._p.thresholds.h_instability
        evidence = Evidence(
            h=h,
            indicator=indicator,
            usable=self._reason in _USABLE,
            slow=self._reason is Reason.LOW_SPEED,
            braking=torque is not None and self._brakes(sample.stamp, torque),
        )
        if self._supervisor.update(sample.stamp, evidence):
            self._log.note(self._supervisor, sample.stamp, self._text)
        known = self._guard.envelope.evidence
        law = self._end_of_stop.ask(COMMANDS[self._supervisor.state], known.grips, seen.car_speed, seen.torque)
        control = self._curve_control
        if control is not None and isfinite(seen.wheel_speed):
            if self._reason is Reason.LOW_SPEED and evidence.braking and isfinite(seen.car_speed):
                # The machine has ended; the envelope gives the brake back, and the law goes on until it has.
                law = Command.INCREASE
            trims = self._guard.envelope.may_trim(seen.car_speed, seen.torque)
            answered = known.verdict is not Release.REFUSED or known.dives or trims
            law = control.ask(sample.stamp, seen, law, answered, self._guard.deceleration)
        self._command = self._given(sample.stamp, law) if isfinite(seen.wheel_speed) else Command.NONE
        self._end_of_stop.commanded(self._command)
        if control is not None:
            control.commanded(sample.stamp, self._command, seen.demand)
        return self._outputs()

    def _given(self, stamp: int, law: Command) -> Command:
        """Return the command for what the law asks for: as the envelope allows, and the other wheel of the axle."""
        pair, torque = self._pair, self._seen.torque
        rolls = law is not Command.NONE and self._rolls(stamp)
        most = Command.INCREASE if pair is None else pair.most(self._wheel, stamp, torque)
        command = self._guard.command(stamp, law, most, rolls)
        # The other wheel of the axle does not follow one that rolls.
        if pair is not None and not rolls:
            released = self._guard.envelope.release in (Release.BY_SLIP, Release.BY_DECELERATION)
            pair.note(self._wheel, stamp, torque, command, released)
        return command

    def _rolls(self, stamp: int) -> bool:
        """Return whether this wheel is to roll for a moment, so that the speed of the car is seen."""
        if self._reference is None or self._curve_control is None:
            return False
        seen = self._seen
        held = self._curve_control.law.slip_set_point
        may_roll = self._guard.envelope.may_roll(seen.torque, seen.demand)
        return self._reference.rolls(
            self._wheel,
            stamp,
            nan if seen.car_is_measured else seen.car_speed,
            self._guard.deceleration,
            seen.torque,
            held if may_roll else nan,
        )

    def _torque_at(self, sample: AlignedSample[SlopeVote]) -> float | None:
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

    def _judge(self, sample: AlignedSample[SlopeVote], torque: float | None) -> tuple[Reason, str]:
        """Return the reason why the machine may not act on this sample, or OK, and its text."""
        vote, guard, seen = sample.payload, self._guard, self._seen
        if torque is None:
            return Reason.NO_DEMAND, sample.missing[self._demand]
        if not isfinite(seen.wheel_speed):
            return Reason.NO_WHEEL_SPEED, sample.missing.get(WHEEL_STATES, f"{WHEEL_STATES}: no speed of this wheel")
        if not isfinite(seen.torque):
            return Reason.NO_PRESSURE, sample.missing[self._inputs.pressure]
        if guard.wheel_text:
            return Reason.WHEEL_SENSOR, guard.wheel_text
        reason, text = vote.validity.reason, vote.validity.text
        slow = reason == Reason.LOW_SPEED
        if slow and not guard.slides:
            text = without_wheel(self._wheel, text)
            return Reason.LOW_SPEED, f"{text}, by {_MAY_BE_LOCKED}" if self._gives_up() else text
        alive = slow or reason in _UNMEASURED or vote.validity.valid
        # With an indicator, a vote that is not ready has not passed a threshold yet; without, its window is not full.
        if not alive and not (reason == Reason.NOT_READY and isfinite(vote.indicator)):
            return Reason.INVALID_SLOPE, of_topic(self._vote, text)
        if guard.pressure_text:
            return _MISMATCH, f"{self._inputs.pressure}: {guard.pressure_text}"
        return Reason.OK, ""

    def _gives_up(self) -> bool:
        """Whether the ABS ends by the speed of a wheel that a lock would bring down as well."""
        machine = self._supervisor
        acted = machine.state is not State.S0 or machine.cause is Cause.LOW_SPEED
        return acted and self._guard.may_be_locked

    def _outputs(self) -> list[Output]:
        machine, envelope = self._supervisor, self._guard.envelope
        state = SupervisorState()
        state.header = header = header_at(self._stamp, self._wheel)
        state.wheel = self._wheel
        state.state = int(machine.state)
        state.previous_state = int(machine.previous_state)
        state.cause = int(machine.cause)
        state.transition_stamp = from_nanoseconds(machine.transition_stamp)
        state.command = int(self._command)
        state.shadow = self._p.shadow
        state.demand_torque = self._torque
        state.slip = self._seen.slip
        state.release = int(envelope.release)
        state.cap = int(envelope.caps.cap)
        state.refused_releases = envelope.refused
        state.unchecked = self._guard.unchecked
        state.validity = validity(self._wheel, self._reason, self._text)
        debug = self._debug(header)
        describe(state, debug, self._curve_control)
        outputs: list[Output] = [(self._state_topic, state)]
        if not self._p.shadow:
            outputs.append(self._heartbeat(header))
        return [*outputs, (self._debug_topic, debug)]

    def _debug(self, header: Header) -> SupervisorDebug:
        """Return the internals of machine and envelope."""
        counts, envelope = self._supervisor.counts, self._guard.envelope
        debug = SupervisorDebug()
        debug.header = header
        debug.wheel = self._wheel
        debug.indicator = self._indicator
        debug.release_slip = envelope.evidence.release_slip
        debug.wheel_deceleration = envelope.evidence.deceleration
        debug.release_deceleration = envelope.evidence.release_deceleration
        debug.transitions = counts.transitions
        debug.instabilities = counts.instabilities
        debug.recoveries = counts.recoveries
        debug.release_timeouts = counts.release_timeouts
        debug.fail_safes = counts.fail_safes
        debug.caps = envelope.caps.count
        return debug

    def _heartbeat(self, header: Header) -> Output:
        """Return the command that is in force, once more: a heartbeat."""
        self._commanded = True
        self._counter = (self._counter + 1) % _COUNTER_END
        command = BrakeCommand()
        command.header = header
        command.wheel = self._wheel
        command.command = int(self._command)
        command.counter = self._counter
        command.valid_for = self._p.valid_for
        return self._command_topic, sealed(command)


def build(parameters: SupervisorParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one per wheel."""
    pairs = wheel_pairs(vehicle, parameters.select_low)
    rear = [wheel.name for wheel in vehicle.wheels if wheel.axle == REAR]
    reference = ReferenceWheel(rear) if len(vehicle.wheels) >= _SHARED and rear else None
    return [
        WheelProcessor(wheel, vehicle, parameters, report, pairs.get(wheel), reference) for wheel in vehicle.wheel_names
    ]
