"""Messages of a car in, messages of this graph out."""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import Kind, SignalMap
from friction_adapter.sources import CanFrames, Fields, Sources
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import UnknownTypeError, message_class
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import Health, Level, Output, Report

_SEQUENCE = re.compile(r"sequence<(.+?)(?:, \d+)?>|(.+)\[\d+\]")
CAN_FRAME = "can_msgs/msg/Frame"


@cache
def installed_fields(type_name: str) -> Fields:
    """Return the fields of an installed type.

    Raises:
        ValueError: the type is not installed.
    """
    try:
        kind: Any = message_class(type_name)
    except UnknownTypeError as error:
        raise ValueError(str(error)) from error
    return Fields({name: _fields(text) for name, text in kind.get_fields_and_field_types().items()})


def _fields(text: str) -> Fields:
    """Return the fields of a type as rosidl describes it: double, std_msgs/Header, sequence<string>, double[9]."""
    sequence = _SEQUENCE.fullmatch(text)
    element = (sequence[1] or sequence[2]) if sequence else text
    members = installed_fields(element.replace("/", "/msg/")).members if "/" in element else {}
    return Fields(members, is_sequence=sequence is not None)


class AdapterProcessor:
    """Makes the messages of one car."""

    def __init__(
        self,
        signal_map: SignalMap,
        fields_of: Callable[[str], Fields],
        report: Report,
        *,
        arrival: Callable[[], int],
        kind_of: Callable[[str], type] | None = None,
    ) -> None:
        """Find every signal.

        Args:
            signal_map: the map.
            fields_of: fields of a message type by its name; raises ValueError where it is unknown.
            report: log function.
            arrival: time at which the message that is processed arrived or was recorded [ns].
            kind_of: class of a message type by its name; None where no class is needed (offline).

        Raises:
            ParameterError: a signal is not there; the text names file, line and what there is.
        """
        self._map = signal_map
        self._report = report
        self._arrival = arrival
        self._frames = _can_frames(signal_map)
        self._mapper = RecordMapper(signal_map, Sources(fields_of, self._frames))
        if self._frames is not None:
            self._frames.keep(self._mapper.sources)
        self.types = signal_map.topics
        """Type of each topic that is needed, by its name."""
        if self._frames is not None:
            self.types[signal_map.can.topic] = CAN_FRAME
        self._kinds = {} if kind_of is None else {topic: kind_of(kind) for topic, kind in self.types.items()}
        self._said: dict[str, int] = {}
        self._count = 0

    @property
    def sensors(self) -> Mapping[str, type]:
        """Topics of the car and their types."""
        return self._kinds

    @property
    def estimates(self) -> Mapping[str, type]:
        """None."""
        return {}

    @property
    def optional(self) -> Collection[str]:
        """None: what a map names is expected."""
        return ()

    @property
    def outputs(self) -> Mapping[str, type]:
        """Topics of this graph."""
        return self._mapper.outputs

    def process(self, topic: str, message: Any) -> Sequence[Output]:
        """Take a message of the car; return the messages that it completes."""
        if self._frames is not None and topic == self._map.can.topic:
            made = self._of_frame(self._frames, message)
        else:
            made = self._mapper.take(topic, message, self._arrival())
        self._count += len(made)
        self._say()
        return made

    def watch(self, ages: Mapping[str, float], now: float) -> Sequence[Output]:
        """Do nothing: the node's diagnostics name a topic that is silent."""
        return ()

    def reset(self) -> None:
        """Start again, as after construction."""
        self._mapper.reset()
        self._said.clear()
        self._count = 0

    def health(self) -> Health:
        """State for diagnostics: WARN once something could not be used."""
        problems = self._problems()
        values = {"messages made": str(self._count), **{text: str(count) for text, count in problems.items()}}
        return Health("map", Level.WARN if problems else Level.OK, ", ".join(problems) or "ok", values)

    def _of_frame(self, frames: CanFrames, message: Any) -> list[Output]:
        stamp = self._arrival() if self._map.can.by_arrival else to_nanoseconds(message.header.stamp)
        made: list[Output] = []
        for frame in frames.decode(message.id, message.is_extended, bytes(message.data[: message.dlc])):
            made += self._mapper.take(frame.name, frame.values, stamp)
        return made

    def never_read(self) -> list[str]:
        """Return a sentence for each signal of the map that has not had one value so far."""
        return self._mapper.never_read()

    def _problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        undecoded = 0 if self._frames is None else self._frames.undecoded
        return {**self._mapper.problems(), **({"frame that cannot be decoded": undecoded} if undecoded else {})}

    def _say(self) -> None:
        for text, count in self._problems().items():
            if count > self._said.get(text, 0):
                self._said[text] = count
                self._report("warning", f"signal map: {text}")


def _can_frames(signal_map: SignalMap) -> CanFrames | None:
    """Return the CAN frames of a map whose frames come on a topic; None where it names no CAN signal.

    Raises:
        ParameterError: it names some, and no topic or DBC file.
    """
    if not any(each.origin.kind is Kind.CAN for each in signal_map.signals):
        return None
    can = signal_map.can
    if can.dbc is None or not can.topic:
        raise ParameterError(f"{signal_map.path}: CAN signals need 'can: {{topic: TOPIC, dbc: FILE}}'")
    return CanFrames(can.dbc)
