"""The shape of layer 2: messages in, messages out, no middleware.

A node and the offline bag runner drive processors in the same way, so that their outputs are equal bit for bit.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Literal, Protocol, runtime_checkable

Output = tuple[str, Any]
"""A relative topic and the message to publish on it."""
Severity = Literal["debug", "info", "warning", "error"]
Report = Callable[[Severity, str], None]
"""Log function of a processor: takes the severity and one line that names topic, wheel or parameter.

Strings that come from a message stand in double quotes, so that lines that differ only in these and in numbers count as
one kind (reports.py).
"""


def silent(severity: Severity, text: str) -> None:
    """A Report that discards everything."""


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


def level_of(reason: int, quiet: Collection[int], broken: Collection[int]) -> Level:
    """Return the level of an estimate's reason in diagnostics, the same in every package.

    Args:
        reason: reason of the last estimate.
        quiet: reasons that belong to ordinary driving.
        broken: reasons that do not go away by waiting.
    """
    return Level.OK if reason in quiet else Level.ERROR if reason in broken else Level.WARN


@dataclass(frozen=True)
class Health:
    """Entry of one processor in /diagnostics."""

    name: str
    """Name of the wheel or of the part."""
    level: Level = Level.OK
    message: str = "ok"
    values: Mapping[str, str] = field(default_factory=dict)


class Reader(Protocol):
    """What takes messages and answers with messages."""

    @property
    def sensors(self) -> Mapping[str, type]:
        """Topics and types of the inputs with sensor QoS (best effort)."""

    @property
    def estimates(self) -> Mapping[str, type]:
        """Topics and types of the inputs with reliable QoS: other nodes' estimates, demands, tyre blocks.

        Best effort as well where a processor has `commands`.
        """

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message; return the resulting outputs. Never raises for the content of a message: it is reported."""


class Processor(Reader, Protocol):
    """Estimator of one wheel or one car, with messages as inputs and outputs; all topics are relative."""

    @property
    def optional(self) -> Collection[str]:
        """Inputs that may never come, and are no fault then."""

    @property
    def outputs(self) -> Mapping[str, type]:
        """Relative topics and types of the outputs."""

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Act on silence; called by a live node only, so its outputs are not part of an offline run.

        A node that commands calls it every 10 ms, and after a stall before it hands on the messages that have waited;
        any other node calls it before each of its diagnostics.

        Args:
            ages: age of each input by the steady clock [s], inf before the first message.
            now: time of the steady clock [s].
        """

    def reset(self) -> None:
        """Start again, as after construction."""

    def health(self) -> Health:
        """State for diagnostics."""


@runtime_checkable
class CommandingProcessor(Processor, Protocol):
    """A processor with outputs that somebody else obeys at once."""

    @property
    def commands(self) -> Mapping[str, float]:
        """Outputs that are commands, and how long each holds after its publication [s]: never sent later than that.

        Empty where nothing follows the clock of the machine: a command then waits for as long as it takes.
        """

    @property
    def acts(self) -> bool:
        """Whether it has a part in what a brake does now: it is not started again then for a service."""

    def hand_over(self) -> Sequence[Output]:
        """Return the commands that give the brake back to the driver, whatever state the processor is in."""


class ProcessorGraph:
    """Passes messages to those that take them, and their outputs to those after them.

    Whoever takes a message takes it before any output that it causes: all of a sample's slips are made before the first
    of them is handed on.
    """

    def __init__(self, readers: Sequence[Reader]) -> None:
        """Connect processors, or nodes around them, by their topics.

        Args:
            readers: all that take part; those that take the same topic are given it in this order.
        """
        self.inputs: dict[str, type] = {}
        self._readers: dict[str, list[Reader]] = {}
        for reader in readers:
            for topics in (reader.sensors, reader.estimates):
                self._connect(reader, topics)

    def feed(self, topic: str, message: Any) -> list[Output]:
        """Take one message; return the resulting outputs of all, in order."""
        given: list[Output] = []
        self._hand_on(topic, message, given)
        # What is appended on the way is handed on in its turn.
        for name, each in given:
            self._hand_on(name, each, given)
        return given

    def _hand_on(self, topic: str, message: Any, given: list[Output]) -> None:
        readers = self._readers.get(topic)
        if readers is not None:
            for reader in readers:
                given.extend(reader.process(topic, message))

    def _connect(self, reader: Reader, topics: Mapping[str, type]) -> None:
        for topic, kind in topics.items():
            self.inputs[topic] = kind
            readers = self._readers.setdefault(topic, [])
            if reader not in readers:
                readers.append(reader)
