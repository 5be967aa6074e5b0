"""<wheel>/friction_slope and the driver's demand in, <wheel>/abs_supervisor and <wheel>/brake_command out."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from friction_msgs.msg import BrakeCommand, BrakeDemand, FrictionSlope, SupervisorState
from sensor_msgs.msg import FluidPressure

from abs_supervisor.braking import TorqueWithHysteresis
from abs_supervisor.fsm import COMMANDS
from abs_supervisor.parameters import SupervisorParameters
from abs_supervisor.supervisor import Evidence, Supervisor
from friction_runtime.aligner import AlignedInput, AlignedSample, Aligner
from friction_runtime.brake_torque import BrakeTorque
from friction_runtime.new_message import new_message
from friction_runtime.processor import Health, Level, Output, Report, silent
from friction_runtime.stamps import from_nanoseconds, header_at, to_nanoseconds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.plausible import HIGHEST_PRESSURE, HIGHEST_TORQUE
from vehicle_models.vehicle import Vehicle

BRAKE_DEMAND = "brake_demand"
_OK, _LOW_SPEED = int(SupervisorState.OK), int(SupervisorState.LOW_SPEED)
_SLOPE_LOW_SPEED = int(FrictionSlope.LOW_SPEED)
"""Of the messages, kept: a message class looks its constants up by a Python function, here at every sample."""
_ALIVE = (FrictionSlope.OK, FrictionSlope.NOT_BRAKING, FrictionSlope.NO_EXCITATION, FrictionSlope.LOW_SPEED)
"""Reasons of friction_slope with which the machine can go on."""


class WheelProcessor:
    """Layer 2 of abs_supervisor. Fires for each friction_slope message, once the demand has reached its stamp."""

    def __init__(self, wheel: str, vehicle: Vehicle, parameters: SupervisorParameters, report: Report = silent) -> None:
        """Build for one wheel of a car; `report` takes what a person should know."""
        self._wheel, self._p, self._report = wheel, parameters, report
        self._gain = vehicle.wheel(wheel).brake_gain
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
        self._aligner: Aligner[FrictionSlope] = Aligner(self._slope, [AlignedInput(self._demand)], parameters.deadline)
        self._supervisor = Supervisor(parameters.thresholds, parameters.tolerance)
        self._hysteresis = TorqueWithHysteresis(parameters.braking_torque, parameters.pressure)
        self.reset()

    def reset(self) -> None:
        """Start anew, as after construction."""
        self._aligner.reset()
        self._supervisor.reset()
        self._hysteresis.reset()
        self._held: tuple[int, float] | None = None
        self._stamp = 0
        self._reason, self._text = SupervisorState.NO_SLOPE, f"{self._slope}: no message yet"
        self._indicator = self._torque = float("nan")

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message, return what follows from it."""
        stamp = to_nanoseconds(message.header.stamp)
        if topic == self._slope:
            refusal = self._aligner.offer_primary(stamp, message)
        else:
            refusal = self._offer_demand(topic, stamp, message)
        if refusal is not None:
            self._report("warning", f"{refusal}: sample refused")
        return [output for sample in self._aligner.ready() for output in self._fire(sample)]

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Fail safe when friction_slope has fallen silent; a silent demand is seen in message time."""
        if self._stamp == 0 or ages[self._slope] <= self._p.stale_after:
            return []
        self._reason, self._text = SupervisorState.NO_SLOPE, f"{self._slope}: silent"
        if self._supervisor.fail(self._stamp):
            self._log_transition("error")
            return self._outputs()
        return []

    def health(self) -> Health:
        """State for diagnostics."""
        machine, counts = self._supervisor, self._supervisor.counts
        values = {
            "state": machine.state.name,
            "cause of the last transition": machine.cause.name.lower(),
            "transitions": str(counts.transitions),
            "instabilities": str(counts.instabilities),
            "recoveries": str(counts.recoveries),
            "release time-outs": str(counts.release_timeouts),
            "fail-safes": str(counts.fail_safes),
            "shadow": str(self._p.shadow).lower(),
        }
        ordinary = self._reason in (_OK, _LOW_SPEED)
        level = Level.OK if ordinary else Level.ERROR
        return Health(self._wheel, level, self._text or f"{machine.state.name}", values)

    def _offer_demand(self, topic: str, stamp: int, message: Any) -> str | None:
        if topic == BRAKE_DEMAND:
            if message.wheel not in ("", self._wheel):
                return None
            pressure = message.pressure
            torque = self._gain * pressure
            if not (abs(pressure) <= HIGHEST_PRESSURE and abs(torque) <= HIGHEST_TORQUE):
                return f"{topic}: {pressure} Pa is no brake pressure"
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
        if sample.rewound:
            self._hysteresis.reset()
            if self._supervisor.restart(sample.stamp):
                self._stamp = sample.stamp
                self._log_transition("info")
        self._stamp, self._indicator = sample.stamp, slope.indicator
        torque = self._torque_at(sample)
        self._reason, self._text = self._judge(sample, torque)
        self._torque = float("nan") if torque is None else torque
        usable = self._reason in (_OK, _LOW_SPEED)
        evidence = Evidence(
            h=slope.h,
            indicator=slope.indicator,
            usable=usable,
            slow=self._reason == _LOW_SPEED,
            braking=torque is not None and self._brakes(sample.stamp, torque),
        )
        if self._supervisor.update(sample.stamp, evidence):
            self._log_transition("info" if usable else "error")
        return self._outputs()

    def _torque_at(self, sample: AlignedSample[FrictionSlope]) -> float | None:
        """Torque the driver asks for [N m]; None where it is not known."""
        if self._demand in sample.values:
            return sample.values[self._demand][0]
        if self._held is not None and 0 <= sample.stamp - self._held[0] <= self._p.demand_timeout * NANOSECONDS:
            return self._held[1]
        return None

    def _brakes(self, stamp: int, torque: float) -> bool:
        if self._p.braking_source == "demand":
            return torque >= self._p.braking_torque
        return self._hysteresis.update(stamp, torque)

    def _judge(self, sample: AlignedSample[FrictionSlope], torque: float | None) -> tuple[int, str]:
        """May the machine act on this sample? The reason and its text."""
        slope = sample.payload
        if torque is None:
            return SupervisorState.NO_DEMAND, sample.missing[self._demand]
        if slope.reason == _SLOPE_LOW_SPEED:
            return _LOW_SPEED, slope.reason_text
        if slope.reason not in _ALIVE and not isfinite(slope.indicator):
            return SupervisorState.INVALID_SLOPE, f"{self._slope}: {slope.reason_text}"
        return _OK, ""

    def _log_transition(self, severity: Any) -> None:
        machine = self._supervisor
        seconds = machine.transition_stamp / NANOSECONDS
        because = f" ({self._text})" if self._text else ""
        self._report(
            severity,
            f"{self._wheel}: {machine.previous_state.name} -> {machine.state.name} at {seconds:.3f} s, "
            f"cause {machine.cause.name.lower()}{because}",
        )

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
        state.transitions = counts.transitions
        state.instabilities = counts.instabilities
        state.recoveries = counts.recoveries
        state.release_timeouts = counts.release_timeouts
        state.fail_safes = counts.fail_safes
        state.valid = self._reason == _OK
        state.reason = self._reason
        state.reason_text = self._text and f"{self._wheel}: {self._text}"
        outputs: list[Output] = [(f"{self._wheel}/abs_supervisor", state)]
        if not self._p.shadow:
            command = new_message(BrakeCommand)
            command.header = header
            command.wheel = self._wheel
            command.command = int(COMMANDS[machine.state])
            outputs.append((f"{self._wheel}/brake_command", command))
        return outputs


def build(parameters: SupervisorParameters, vehicle: Vehicle, report: Report = silent) -> list[WheelProcessor]:
    """Make the processors: one a wheel."""
    return [WheelProcessor(wheel, vehicle, parameters, report) for wheel in vehicle.wheel_names]
