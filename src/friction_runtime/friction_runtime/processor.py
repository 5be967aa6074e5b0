"""The shape of layer 2: messages in, messages out, no middleware.

A node and the offline bag runner drive processors alike, so that what they give is the same, bit for bit.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Literal, Protocol

Output = tuple[str, Any]
"""A relative topic and the message for it."""
Severity = Literal["debug", "info", "warning", "error"]
Report = Callable[[Severity, str], None]
"""Takes what a processor has to say to a person: the severity and one line that names topic, wheel or parameter.

Strings that come from a message stand in double quotes, so that lines that differ in these and in numbers alone can be
told to be of one kind (report_kind.py).
"""


def silent(severity: Severity, text: str) -> None:
    """A Report that says nothing."""


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


def level_of(reason: int, quiet: Collection[int], broken: Collection[int]) -> Level:
    """Level that a reason for an estimate or against it has in diagnostics, the same in every package.

    Args:
        reason: of the last estimate.
        quiet: reasons that belong to ordinary driving.
        broken: reasons that no wait cures.
    """
    return Level.OK if reason in quiet else Level.ERROR if reason in broken else Level.WARN


@dataclass(frozen=True)
class Health:
    """What /diagnostics says of one processor."""

    name: str
    """Of the wheel, or of the part."""
    level: Level = Level.OK
    message: str = "ok"
    values: Mapping[str, str] = field(default_factory=dict)


class Processor(Protocol):
    """One wheel's (or one car's) estimator behind its messages."""

    @property
    def sensors(self) -> Mapping[str, type]:
        """Relative topics and types it takes with sensor QoS (best effort)."""

    @property
    def estimates(self) -> Mapping[str, type]:
        """Relative topics and types it takes with reliable QoS: other nodes' estimates, demands, tyre blocks."""

    @property
    def optional(self) -> Collection[str]:
        """Inputs that may never come, and are no fault then."""

    @property
    def outputs(self) -> Mapping[str, type]:
        """Relative topics and types it gives."""

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take one message, return what follows from it. Never raises for what a message holds: it reports."""

    def watch(self, ages: Mapping[str, float]) -> Sequence[Output]:
        """Act on silence. `ages` [s] of each input by the node's clock, inf before the first message.

        Called by a live node only, every 20 ms: what it gives is not part of an offline run.
        """

    def reset(self) -> None:
        """Start anew, as after construction."""

    def health(self) -> Health:
        """State for diagnostics."""
