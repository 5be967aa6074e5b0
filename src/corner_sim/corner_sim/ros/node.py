"""The plant as a node: it keeps the pace, waits for commands in lock-step, and publishes."""

from collections.abc import Sequence
from enum import Enum
from functools import partial
from time import monotonic

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from friction_msgs.msg import BrakeCommand, BrakeDemand
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import Trigger

from corner_sim.car_plant import CAR
from corner_sim.parameters import SimParameters
from corner_sim.plant import SAMPLE_TIME
from corner_sim.ros import messages
from corner_sim.ros.command_watch import CommandWatch
from corner_sim.ros.simulation import Simulation
from friction_parameters.parameter import ParameterError
from friction_runtime import qos
from friction_runtime.messages import from_nanoseconds
from friction_runtime.parameters import declare
from friction_runtime.processor import Level
from friction_runtime.spin import run
from vehicle_models.vehicle_file import load_vehicle

_MAX_LAG = 0.5
"""Wall time [s] behind schedule beyond which the schedule is shifted: what subscribers' queues hold at 200 Hz."""


class Pace:
    """Schedule of samples against the steady clock.

    The schedule is absolute, so the mean rate does not drift. After a stall the samples that are due follow at once,
    and are counted; after a stall longer than 0.5 s the schedule shifts, and the shift is counted too. No sample is
    left out.
    """

    def __init__(self, real_time_factor: float, now: float) -> None:
        """Make the first sample due at `now` [s, steady clock]; factor > 0, or 0: always due."""
        self._period = SAMPLE_TIME / real_time_factor if real_time_factor > 0.0 else 0.0
        self._next = now
        self.overruns = 0
        """Samples that came more than one period late."""
        self.worst_lateness = 0.0
        """Largest delay of a sample behind the schedule [s]."""
        self.shifted = 0.0
        """Wall time by which the schedule was shifted after stalls [s]."""

    def due(self, now: float) -> bool:
        """Whether the next sample is due now or within half a period, so that a slightly early timer serves it."""
        return now >= self._next - 0.5 * self._period

    def taken(self, now: float) -> None:
        """Note that the due sample is taken at `now` [s]."""
        if self._period > 0.0:
            lateness = now - self._next
            self.worst_lateness = max(self.worst_lateness, lateness)
            self.overruns += lateness > self._period
            if lateness > _MAX_LAG:
                self.shifted += lateness
                self._next = now
        self._next += self._period


_NAME = "corner_sim"
_DIAGNOSTICS_PERIOD = 1.0
"""Period of the diagnostics [s]."""
_LINGER = 5.0
"""Wall time [s] the last messages may take to reach reliable subscribers before the node exits; one may be dead."""


class Phase(Enum):
    """Phase of a run."""

    WAITING_FOR_SUBSCRIBERS = "waiting for subscribers"
    SETTLING = "waiting for the other nodes to find each other"
    WAITING_FOR_START = "waiting for ~/start"
    RUNNING = "running"
    DONE = "done"


class CornerSimNode(Node):
    """Publishes the sensors and the truth of a Simulation at 200 Hz of message time."""

    def __init__(self) -> None:
        """Declare parameters, build the run, connect.

        Raises:
            ParameterError: a parameter or the vehicle file is bad.
        """
        super().__init__(_NAME)
        self.exit_code = 0
        """Exit code for the process: 1 when a time-out ended it."""
        self._requested = declare(self, SimParameters, self._check)
        p = self._requested
        self._vehicle = load_vehicle(p.vehicle_file)
        self._start_stamp = p.start_stamp or Clock().now().nanoseconds
        try:
            self._simulation = Simulation(p, self._vehicle, self._start_stamp)
        except ValueError as error:
            raise ParameterError(str(error)) from error
        self._in_force = p
        self._published = False
        self._published_at = 0.0
        self._failure: str | None = None
        self._refused = 0
        self._pace = Pace(p.real_time_factor, monotonic())
        self._waiting_since = monotonic()
        self._settled_at = 0.0
        self._shift_reported = 0.0
        self._phase = Phase.WAITING_FOR_SUBSCRIBERS if p.autostart else Phase.WAITING_FOR_START
        wheels = self._vehicle.wheel_names
        given = messages.topics(
            wheels, p.vehicle_velocity, p.demand_source == "profile", p.tyre_signals, p.model == CAR
        )
        self._outputs = {topic: qos.publish(self, kind, topic) for topic, kind in given.items()}
        self._clock_output = qos.publish(self, ClockMessage, "/clock") if p.publish_clock else None
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        # In lock-step the plant waits for the command as long as it takes.
        profile = qos.ESTIMATE if p.lock_step else qos.COMMAND
        self._command_watches = {topic: CommandWatch(topic) for topic in (f"{wheel}/brake_command" for wheel in wheels)}
        self._command_inputs = {
            topic: qos.subscribe(self, BrakeCommand, topic, partial(self._on_command, wheel), profile, watch.callbacks)
            for wheel, (topic, watch) in zip(wheels, self._command_watches.items(), strict=True)
        }
        if p.demand_source == "topic":
            qos.subscribe(self, BrakeDemand, "brake_demand", self._on_demand, qos.ESTIMATE)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(Trigger, "~/start", self._on_start)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_DIAGNOSTICS_PERIOD, self._on_diagnostics, clock=steady)
        self._timer = self.create_timer(SAMPLE_TIME / max(p.real_time_factor, 1.0), self._on_timer, clock=steady)

    def _check(self, parameters: SimParameters) -> None:
        """Refuse changes that do not make a valid run; keep the others for the next reset."""
        Simulation(parameters, self._vehicle, self._start_stamp)
        self._requested = parameters
        self.get_logger().info("parameters changed: they take effect at the next ~/reset")

    def _on_timer(self) -> None:
        now = monotonic()
        p = self._in_force
        if self._phase is Phase.WAITING_FOR_SUBSCRIBERS:
            if not (missing := self._missing_peers()):
                self._phase = Phase.SETTLING
                self._settled_at = now + (p.settle_time if p.lock_step or p.wait_for_subscribers else 0.0)
            elif now - self._waiting_since > p.lock_step_timeout:
                self._fail(f"not started: still missing after {p.lock_step_timeout} s: {', '.join(missing)}")
        if self._phase is Phase.SETTLING and now >= self._settled_at:
            self._begin()
        self._run_due_samples()

    def _missing_peers(self) -> list[str]:
        """Return what must be there before the first sample and is not."""
        p = self._in_force
        missing: list[str] = []
        if p.lock_step:
            inputs = self._command_inputs.items()
            missing = [f"a publisher of {topic}" for topic, taken in inputs if not taken.get_publisher_count()]
        if (subscribed := self._outputs["wheel_states"].get_subscription_count()) < p.wait_for_subscribers:
            missing.append(
                f"{p.wait_for_subscribers - subscribed} of {p.wait_for_subscribers} wheel_states subscribers"
            )
        return missing

    def _fail(self, text: str) -> None:
        """Report once, and in diagnostics, that the plant cannot go on; with exit_when_done, exit with code 1."""
        if self._failure is not None:
            return
        self._failure = text
        self.get_logger().error(text)
        if self._in_force.exit_when_done:
            self.exit_code = 1
            rclpy.try_shutdown()

    def _begin(self) -> None:
        self._phase = Phase.RUNNING
        self.get_logger().info(f"running from stamp {self._start_stamp} ns")
        # after the log: its first line takes 70 ms
        self._pace = Pace(self._in_force.real_time_factor, monotonic())

    def _run_due_samples(self) -> None:
        while self._phase is Phase.RUNNING and self._pace.due(monotonic()):
            if self._published:
                if self._is_waiting_for_commands():
                    return
                self._simulation.advance()
            self._pace.taken(monotonic())
            self._publish()
            if (reason := self._simulation.end) is not None:
                self._finish(reason)

    def _is_waiting_for_commands(self) -> bool:
        """Whether, in lock-step, a wheel has not yet answered the last sample. After the time-out that is a failure."""
        p = self._in_force
        if not p.lock_step or not (silent := self._simulation.unanswered):
            return False
        if monotonic() - self._published_at > p.lock_step_timeout:
            self._fail(
                f"lock-step: no brake_command with stamp {self._simulation.stamp} ns within {p.lock_step_timeout} s "
                f"from {', '.join(silent)}: is its supervisor alive, and not in shadow mode? The plant holds still"
            )
        return True

    def _publish(self) -> None:
        if self._clock_output is not None:
            self._clock_output.publish(ClockMessage(clock=from_nanoseconds(self._simulation.stamp)))
        self._published, self._published_at, self._failure = True, monotonic(), None
        # Nobody else gets what is published now: late subscribers are not sent what was before them.
        heard = any(each.get_subscription_count() for topic, each in self._outputs.items() if messages.is_truth(topic))
        for topic, message in self._simulation.messages(truth=heard):
            self._outputs[topic].publish(message)

    def _finish(self, reason: str) -> None:
        self._phase = Phase.DONE
        again = (
            ""
            if self._in_force.exit_when_done
            else f"; again: {self.get_fully_qualified_name()}/reset, a std_srvs/Trigger"
        )
        self.get_logger().info(f"done after {self._simulation.time:.3f} s: {reason}{again}")
        if self._in_force.exit_when_done:
            until = monotonic() + _LINGER
            for output in self._outputs.values():
                output.wait_for_all_acked(Duration(seconds=max(until - monotonic(), 0.0)))
            rclpy.try_shutdown()

    def _on_command(self, wheel: str, message: BrakeCommand) -> None:
        self._note_refusal(self._simulation.take_command(wheel, message))
        if self._in_force.lock_step:
            self._run_due_samples()

    def _on_demand(self, message: BrakeDemand) -> None:
        self._note_refusal(self._simulation.take_demand(message))

    def _note_refusal(self, refusal: str | None) -> None:
        if refusal is not None:
            self._refused += 1
            self.get_logger().warning(refusal, throttle_duration_sec=5.0)

    def _on_start(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._phase not in (Phase.RUNNING, Phase.DONE)
        missing = self._missing_peers()
        if not response.success:
            response.message = f"{self._phase.value}: call ~/reset first"
        elif missing:
            self._phase, self._waiting_since = Phase.WAITING_FOR_SUBSCRIBERS, monotonic()
            response.message = f"waiting for {', '.join(missing)}"
        else:
            self._begin()
            response.message = self._phase.value
        return response

    def _on_reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._in_force = self._requested
        self._simulation = Simulation(self._in_force, self._vehicle, self._start_stamp)
        self._published = False
        self._failure = None
        if self._in_force.autostart:
            self._begin()
        else:
            self._phase = Phase.WAITING_FOR_START
        response.success = True
        response.message = f"back at stamp {self._start_stamp} ns, {self._phase.value}"
        self.get_logger().info(f"reset: {response.message}")
        return response

    def _sender_findings(self) -> list[str]:
        """Return what is wrong with the senders of commands."""
        found: list[str] = []
        for topic, watch in self._command_watches.items():
            found += watch.findings(self._command_inputs[topic].get_publisher_count())
        return found

    def _on_diagnostics(self) -> None:
        simulation, pace = self._simulation, self._pace
        level, text = Level.OK, self._phase.value
        senders = self._sender_findings()
        expired = [] if self._in_force.lock_step else simulation.expired
        if self._phase is Phase.RUNNING and (expired or senders):
            silent = [f"brake_command silent, taken as NONE: {', '.join(expired)}"] if expired else []
            level, text = Level.WARN, "; ".join(silent + senders)
        elif pace.shifted > self._shift_reported:
            level, text = Level.WARN, f"{text}; the machine is too slow: {pace.shifted:.3f} s behind the wall clock"
        self._shift_reported = pace.shifted
        if self._failure is not None:
            level, text = Level.ERROR, self._failure
        values = {
            "message time [s]": f"{simulation.time:.3f}",
            "speed [m/s]": f"{simulation.speed:.3f}",
            "distance [m]": f"{simulation.distance:.3f}",
            "samples": str(simulation.index + self._published),
            "overruns": str(pace.overruns),
            "worst lateness [s]": f"{pace.worst_lateness:.4f}",
            "schedule shifted [s]": f"{pace.shifted:.3f}",
            "messages refused": str(self._refused),
            "commands lost": str(simulation.commands_lost),
            "new senders of commands": str(simulation.new_senders),
            "command deadlines missed": str(sum(watch.missed for watch in self._command_watches.values())),
        }
        array = DiagnosticArray()
        array.header.stamp = Clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=bytes([level]),
                name=f"{self.get_fully_qualified_name()}: plant",
                message=text,
                hardware_id="plant",
                values=[KeyValue(key=key, value=value) for key, value in values.items()],
            )
        ]
        self._diagnostics.publish(array)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; return 2 for a bad parameter, 1 for a time-out with exit_when_done, else 0."""
    made: list[CornerSimNode] = []

    def make() -> CornerSimNode:
        made.append(CornerSimNode())
        return made[0]

    code = run(_NAME, SimParameters, make, args)
    return code or (made[0].exit_code if made else 0)
