"""Sources of signals: fields of messages, frames of a CAN bus by a DBC file, columns of a table.

Fields are named by paths: `a.b`, `a[2]`, `velocity[name=wheel_fl]`, `wheels[id=3].speed`. `x[key=value]` picks by name.
Where the elements of `x` are messages, it is the first whose field `key` has the value; else it is the element of `x`
at the place that the value has in the sequence `key` beside `x`, as in a JointState. cantools is needed only where a
map names CAN signals.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any, Protocol

from friction_adapter.signal_map import Kind, Origin
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError

_STEP = re.compile(r"([A-Za-z]\w*)(?:\[(?:(\d+)|([A-Za-z]\w*)=([^\[\]=]+))\])?", re.ASCII)
INSTALL_LINE = install_line("cantools")
_MOST_LISTED = 30
TABLE = "table"
"""Name of the only source of a table."""
Read = Callable[[Any], Any]


@dataclass(frozen=True)
class Fields:
    """Fields of a message type, or of the elements of a sequence."""

    members: Mapping[str, Fields]
    """By name; empty for a number or a text."""
    is_sequence: bool = False


@dataclass(frozen=True)
class _Step:
    name: str
    index: int | None = None
    key: str = ""
    value: str = ""


class FieldPath:
    """A path, parsed."""

    def __init__(self, text: str) -> None:
        """Parse a path.

        Raises:
            ValueError: it is not a path.
        """
        self.text = text
        self._steps = [self._step(part) for part in _parts(text)]

    def _step(self, part: str) -> _Step:
        match = _STEP.fullmatch(part)
        if match is None:
            raise ValueError(f"'{self.text}' is no field: a field is like a.b, a[0] or velocity[name=wheel_fl]")
        name, index, key, value = match.groups()
        return _Step(name, int(index) if index else None, key or "", value or "")

    def check(self, fields: Fields) -> None:
        """Refuse a path that the type does not have.

        Raises:
            ValueError: the text names the fields there are.
        """
        done: list[str] = []
        for step in self._steps:
            below = fields.members.get(step.name)
            where = ".".join(done)
            if below is None:
                there = ", ".join(fields.members) or "none: it is a value"
                raise ValueError(f"there is no field '{step.name}'{' in ' + where if where else ''}: {there}")
            picks = step.index is not None or bool(step.key)
            if below.is_sequence and not picks:
                raise ValueError(f"'{step.name}' is a sequence: pick one, as {step.name}[0] or {step.name}[name=...]")
            if picks and not below.is_sequence:
                raise ValueError(f"'{step.name}' is no sequence: leave out the brackets")
            if step.key:
                among = below.members or {name: each for name, each in fields.members.items() if each.is_sequence}
                if step.key not in among:
                    raise ValueError(f"'{step.name}' cannot be picked by '{step.key}': {', '.join(among) or 'nothing'}")
            done.append(step.name)
            fields = below
        if fields.members:
            shown = ", ".join(f"{self.text}.{name}" for name in fields.members)
            raise ValueError(f"'{self.text}' is a message, not a value: {shown}")

    def reader(self) -> Callable[[Any], Any]:
        """Return a function that reads the value from a message.

        It raises LookupError, ValueError or AttributeError where the message does not hold the value.
        """
        if all(step.index is None and not step.key for step in self._steps):
            return attrgetter(self.text)
        steps = self._steps

        def read(message: Any) -> Any:
            for step in steps:
                message = _taken(message, step)
            return message

        return read


def _parts(text: str) -> list[str]:
    """Split at the dots outside of brackets."""
    return re.split(r"\.(?![^\[]*\])", text)


def _taken(message: Any, step: _Step) -> Any:
    below = getattr(message, step.name)
    if step.index is not None:
        return below[step.index]
    if not step.key:
        return below
    if len(below) and hasattr(below[0], step.key):
        return _picked(below, step)
    return below[list(getattr(message, step.key)).index(step.value)]


def _picked(elements: Any, step: _Step) -> Any:
    """Return the first element whose field has the value.

    Raises:
        ValueError: there is none.
    """
    for element in elements:
        if str(getattr(element, step.key)) == step.value:
            return element
    raise ValueError(f"no {step.name} has {step.key} = {step.value}")


@dataclass(frozen=True)
class Frame:
    """A decoded frame."""

    name: str
    values: Mapping[str, Any]
    """Physical values by the name of the signal, in the units of the DBC file."""


class CanFrames:
    """Signals of a DBC file."""

    def __init__(self, dbc: Path) -> None:
        """Read a DBC file.

        Raises:
            ParameterError: cantools is not installed, or the file cannot be read.
        """
        try:
            from cantools.database import load_file
        except ImportError as error:
            raise ParameterError(f"CAN signals need two more packages: {INSTALL_LINE}") from error
        try:
            self._database = load_file(dbc)
        except OSError as error:
            raise ParameterError(f"DBC file {dbc}: {error.strerror}") from error
        except Exception as error:  # cantools passes on whatever its parsers raise
            raise ParameterError(f"DBC file {dbc} cannot be read: {error}") from error
        self._path = dbc
        self._by_id = {(each.frame_id, each.is_extended_frame): each for each in self._database.messages}
        self.undecoded = 0
        """Frames of the DBC file that could not be decoded, as their data is too short or means nothing."""

    def find(self, name: str) -> tuple[str, str, str]:
        """Return frame, name within it and unit of a signal, given as SIGNAL or FRAME.SIGNAL.

        Raises:
            ValueError: there is no such signal, or several; the text names those there are.
        """
        signals = [(frame.name, each) for frame in self._database.messages for each in frame.signals]
        found = [
            (frame, each.name, each.unit or "")
            for frame, each in signals
            if name in (each.name, f"{frame}.{each.name}")
        ]
        if len(found) > 1:
            several = ", ".join(f"{frame}.{signal}" for frame, signal, _ in found)
            raise ValueError(f"several CAN signals have the name '{name}': {several}")
        if not found:
            names = list(dict.fromkeys(each.name for _, each in signals))
            near = get_close_matches(name, names, _MOST_LISTED, 0.4) or sorted(names)[:_MOST_LISTED]
            more = f", and {len(names) - len(near)} more" if len(near) < len(names) else ""
            raise ValueError(f"{self._path} has no CAN signal '{name}': there are {', '.join(near)}{more}")
        return found[0]

    def keep(self, names: Collection[str]) -> None:
        """Decode these frames only."""
        self._by_id = {key: each for key, each in self._by_id.items() if each.name in names}

    def decode(self, frame_id: int, is_extended: bool, data: bytes) -> Frame | None:
        """Decode a frame; None for one that is not kept, or that cannot be decoded."""
        message = self._by_id.get((frame_id, is_extended))
        if message is None:
            return None
        try:
            values = message.decode(data, decode_choices=False)
        except Exception:  # cantools passes on errors of its bit reader
            self.undecoded += 1
            return None
        return Frame(message.name, values)


class CanDatabase(Protocol):
    """Signals of a DBC file."""

    def find(self, name: str) -> tuple[str, str, str]:
        """Return frame, name within it and unit of a signal, given as SIGNAL or FRAME.SIGNAL.

        Raises:
            ValueError: there is no such signal, or several; the text names those there are.
        """


@dataclass(frozen=True)
class Found:
    """Where one field of a signal is."""

    source: str
    """Topic, CAN frame, or TABLE: what brings the value."""
    read: Read
    """Reads it from a message of the source, or from its values by name."""
    unit: str = ""
    """Unit by the DBC file, as it is written there."""


@dataclass(frozen=True)
class Sources:
    """The sources at hand; None for a kind that is not."""

    fields_of: Callable[[str], Fields] | None = None
    """Fields of a message type by its name; raises ValueError where it is unknown."""
    can: CanDatabase | None = None
    columns: Collection[str] | None = None

    def find(self, origin: Origin, field: str) -> Found:
        """Find a field of a signal.

        Raises:
            ValueError: it is not there; the text names the fields there are.
        """
        if origin.kind is Kind.TOPIC:
            if self.fields_of is None:
                raise ValueError(f"it comes from the topic {origin.topic}, and there are no topics here")
            path = FieldPath(field)
            try:
                path.check(self.fields_of(origin.type))
            except ValueError as error:
                raise ValueError(f"{origin.type}: {error}") from error
            return Found(origin.topic, path.reader())
        if origin.kind is Kind.CAN:
            if self.can is None:
                raise ValueError("it comes from CAN, and no DBC file is given: `can: {dbc: FILE}` in the map, or --dbc")
            frame, name, unit = self.can.find(field)
            return Found(frame, itemgetter(name), unit)
        if self.columns is None:
            raise ValueError("it comes from a table, and this is none")
        if field not in self.columns:
            raise ValueError(f"there is no column '{field}': {', '.join(self.columns)}")
        return Found(TABLE, itemgetter(field))
