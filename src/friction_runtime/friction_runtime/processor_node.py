"""Layer 3, the same for every estimator: parameters, subscriptions, publishers, diagnostics around processors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from time import monotonic
from typing import Any, Generic, Protocol, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from friction_parameters.parameter import ParameterError, ignored
from friction_runtime import qos
from friction_runtime.fault_isolation import FaultIsolatedProcessor
from friction_runtime.parameters import declare
from friction_runtime.processor import CommandingProcessor, Health, Level, Output, Processor, Report, Severity
from friction_runtime.reports import ReportLimit
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle


class NodeParameters(Protocol):
    """The parameters that every node has."""

    @property
    def vehicle_file(self) -> str:
        """Vehicle file of the car."""


Parameters = TypeVar("Parameters", bound=NodeParameters)
Connect = Callable[["ProcessorNode[Any]"], None]
"""Sees to it that a node gets its inputs; called whenever these may have changed."""

_WATCH_PERIOD = 0.01
"""The supervisor must have released control 50 ms after a lost input was due."""
_STALL = 2.0 * _WATCH_PERIOD
"""Time without a watch after which messages that wait are old until the processors have looked at the clock [s]."""
_DIAGNOSTICS_PERIOD = 1.0


@dataclass(frozen=True)
class _Input:
    """An input of a node."""

    topic: str
    """Relative name, by which the processors know it."""
    kind: type
    profile: QoSProfile


def subscribe_to_all(node: ProcessorNode[Any]) -> None:
    """Subscribe to every input of a node, which is alone in its process."""
    for name in (*node.sensors, *node.estimates):
        node.subscribe(name, partial(node.process, name))


class ProcessorNode(Node, Generic[Parameters]):
    """A node around processors: it moves messages and holds no estimate.

    Topics of processors are relative, so a namespace and remapping work; those of the node have their full names.
    `~/reset` (std_srvs/Trigger) resets every processor, unless one has a part in what a brake does now. Staleness is by
    the steady clock of the machine; everything else is by message stamps.
    """

    def __init__(
        self,
        name: str,
        parameter_class: type[Parameters],
        build: Callable[[Parameters, Vehicle, Report], Sequence[Processor]],
        connect: Connect = subscribe_to_all,
    ) -> None:
        """Declare, build and connect.

        Args:
            name: name of the node.
            parameter_class: dataclass of its parameters.
            build: makes the processors from the parameters and the car. It is called again when a parameter changes,
                so the estimators start again; topics that are no longer needed fall silent.
            connect: sees to it that messages for the inputs reach `process`.

        Raises:
            ParameterError: a parameter or the vehicle file is bad.
        """
        super().__init__(name)
        self._build = build
        self._connect = connect
        self._limit = ReportLimit()
        self._unsaid: list[tuple[Severity, str]] = []
        self._outputs: dict[str, tuple[str, Publisher]] = {}
        """Full name and publisher of each output, by its relative name."""
        self._inputs: dict[str, _Input] = {}
        """Inputs by their full names, those that no processor needs any more too."""
        self._subscribed: set[str] = set()
        self._arrivals: dict[str, float] = {}
        self._counts: dict[str, int] = {}
        self._readers: dict[str, list[FaultIsolatedProcessor]] = {}
        self._watched = monotonic()
        self._ignored: set[str] = set()
        parameters = declare(self, parameter_class, self._apply)
        self._vehicle = load_vehicle(parameters.vehicle_file)
        try:
            self._apply(parameters)
        except ValueError as error:
            raise ParameterError(str(error)) from error
        self._say()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_service(Trigger, "~/reset", self._on_reset)
        if self._commands:
            self.create_timer(_WATCH_PERIOD, self._on_watch, clock=steady)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(_DIAGNOSTICS_PERIOD, self._on_diagnostics, clock=steady)

    def _apply(self, parameters: Parameters) -> None:
        """Replace the processors by new ones for these parameters. If that fails, the old ones stay."""
        processors = [
            FaultIsolatedProcessor(each, self._report) for each in self._build(parameters, self._vehicle, self._report)
        ]
        for text in ignored(parameters):
            if text not in self._ignored:
                self._ignored.add(text)
                self._report("warning", text)
        self._processors = processors
        self._commands = any(isinstance(each.processor, CommandingProcessor) for each in processors)
        self._readers = {}
        for isolated in processors:
            processor = isolated.processor
            for topic, kind in processor.outputs.items():
                if topic not in self._outputs:
                    publisher = qos.publish(self, kind, topic, _offered(processor, topic))
                    self._outputs[topic] = publisher.topic_name, publisher
            for inputs, profile in ((processor.sensors, qos.SENSOR), (processor.estimates, _asked(processor))):
                for topic, kind in inputs.items():
                    if topic not in self._counts:
                        self._counts[topic] = 0
                        self._inputs[self.resolve_topic_name(topic)] = _Input(topic, kind, profile)
                    self._readers.setdefault(topic, []).append(isolated)
        self._connect(self)

    @property
    def sensors(self) -> Mapping[str, type]:
        """Full names and types of the inputs with sensor QoS."""
        return {name: each.kind for name, each in self._inputs.items() if each.profile is qos.SENSOR}

    @property
    def estimates(self) -> Mapping[str, type]:
        """Full names and types of the other inputs."""
        return {name: each.kind for name, each in self._inputs.items() if each.profile is not qos.SENSOR}

    @property
    def outputs(self) -> Collection[str]:
        """Full names of the outputs."""
        return [name for name, _ in self._outputs.values()]

    def subscribe(self, name: str, callback: Callable[[Any], object]) -> None:
        """Let the middleware hand every message of one input, by its full name, to a function; once for each input."""
        if name not in self._subscribed:
            self._subscribed.add(name)
            given = self._inputs[name]
            qos.subscribe(self, given.kind, given.topic, callback, given.profile)

    def _report(self, severity: Severity, text: str) -> None:
        """Defer logging until outputs are published: the first log call of a process costs 20 ms."""
        self._unsaid.append((severity, text))

    def _say(self) -> None:
        """Log what was reported; warnings and errors of one kind at a limited rate."""
        if not self._unsaid:
            return
        reports, self._unsaid = self._unsaid, []
        logger = self.get_logger()
        for severity, text in reports:
            if severity == "debug":
                logger.debug(text)
            elif severity == "info":
                logger.info(text)
            elif self._limit.passes(text, monotonic()):
                if severity == "warning":
                    logger.warning(text)
                else:
                    logger.error(text)

    def process(self, name: str, message: Any) -> list[Output]:
        """Take a message of one input, by its full name; publish the resulting outputs, and return them likewise."""
        now = monotonic()
        if self._commands and now - self._watched > _STALL:
            self._on_watch()
        topic = self._inputs[name].topic
        self._arrivals[topic] = now
        self._counts[topic] += 1
        given: list[Output] = []
        for processor in self._readers.get(topic, ()):
            for output, answer in processor.process(topic, message):
                full_name, publisher = self._outputs[output]
                publisher.publish(answer)
                given.append((full_name, answer))
        self._say()
        return given

    def _on_watch(self) -> None:
        self._watched = now = monotonic()
        ages = self._ages(now)
        for processor in self._processors:
            for topic, message in processor.watch(ages, now):
                self._outputs[topic][1].publish(message)
        self._say()

    def _ages(self, now: float) -> dict[str, float]:
        return {topic: now - self._arrivals.get(topic, -inf) for topic in self._readers}

    def _on_reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        acting = [each for each in self._processors if _acts(each)]
        if acting:
            response.success = False
            response.message = f"{self.get_name()}: not while a brake is applied"
            return response
        for processor in self._processors:
            processor.reset()
        self._say()
        response.success = True
        response.message = f"{self.get_name()}: started again"
        self.get_logger().info("reset by service")
        return response

    def _on_diagnostics(self) -> None:
        if not self._commands:
            self._on_watch()  # no other processor depends on silence
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        message.status = [self._status(processor.health()) for processor in self._processors]
        message.status.append(self._inputs_status())
        self._diagnostics.publish(message)

    def _inputs_status(self) -> DiagnosticStatus:
        ages = self._ages(monotonic())
        silent_topics = [
            topic
            for topic, age in ages.items()
            if age > _DIAGNOSTICS_PERIOD and not (age == inf and self._may_never_come(topic))
        ]
        values: dict[str, str] = {}
        for topic, age in ages.items():
            values[f"{topic} rate [1/s]"] = f"{self._counts[topic] / _DIAGNOSTICS_PERIOD:.0f}"
            values[f"{topic} age [s]"] = f"{age:.3f}"
            self._counts[topic] = 0
        text = f"no message within {_DIAGNOSTICS_PERIOD:.0f} s on {', '.join(silent_topics)}" if silent_topics else "ok"
        return self._status(Health("inputs", Level.WARN if silent_topics else Level.OK, text, values))

    def _may_never_come(self, topic: str) -> bool:
        return all(topic in reader.processor.optional for reader in self._readers[topic])

    def _status(self, health: Health) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=bytes([health.level]),
            name=f"{self.get_fully_qualified_name()}: {health.name}",
            message=health.message,
            hardware_id=health.name,
            values=[KeyValue(key=key, value=value) for key, value in health.values.items()],
        )


def _commands(processor: Processor) -> Mapping[str, float]:
    return processor.commands if isinstance(processor, CommandingProcessor) else {}


def _acts(isolated: FaultIsolatedProcessor) -> bool:
    return isinstance(isolated.processor, CommandingProcessor) and isolated.processor.acts


def _offered(processor: Processor, topic: str) -> QoSProfile:
    """Return the QoS with which an output is published."""
    commands = _commands(processor)
    return qos.command(commands[topic]) if topic in commands else qos.ESTIMATE


def _asked(processor: Processor) -> QoSProfile:
    """Return the QoS with which estimates are subscribed to.

    Whoever commands by the clock of the machine has no use for what is old. A reliable reader that has been stopped
    gets nothing new for half a second, until the middleware has sorted out what it has missed.
    """
    return qos.SENSOR if _commands(processor) else qos.ESTIMATE
