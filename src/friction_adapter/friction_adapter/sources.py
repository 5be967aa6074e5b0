"""Sources of signals: fields of messages, frames of a CAN bus by a DBC file, columns of a table.

Fields are named by paths: `a.b`, `a[2]`, `velocity[name=wheel_fl]`, `wheels[id=3].speed`. `x[key=value]` picks by name.
Where the elements of `x` are messages, it is the first whose field `key` has the value; else it is the element of `x`
at the place that the value has in the sequence `key` beside `x`, as in a JointState. cantools is needed only where a
map names CAN signals.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
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
PAGE = " page "
"""Between a frame and the pages of it that a source is."""
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
    """A decoded frame, or one page of a multiplexed one."""

    name: str
    """Of the source: that of the frame, with its page."""
    frame: str
    values: Mapping[str, Any]
    """Physical values by the name of the signal, in the units of the DBC file."""


@dataclass(frozen=True)
class _Page:
    """When a source is in a frame."""

    multiplexer: str
    """Signal that tells the page; empty where the source is in all of them."""
    pages: tuple[int, ...] = ()


class CanFrames:
    """Signals of a DBC file."""

    def __init__(self, dbc: Path) -> None:
        """Read a DBC file.

        Raises:
            ParameterError: cantools is not installed, or the file cannot be read.
        """
        try:
            from cantools.database import load_file, load_string
        except ImportError as error:
            raise ParameterError(f"CAN signals need two more packages: {INSTALL_LINE}") from error
        try:
            self._database, self.notes = _read(load_file, load_string, dbc)
            """The file, and what is wrong with frames that a map may not need."""
        except OSError as error:
            raise ParameterError(f"DBC file {dbc}: {error.strerror}") from error
        except Exception as error:  # cantools passes on whatever its parsers raise
            raise ParameterError(f"DBC file {dbc} cannot be read: {error}") from error
        self._path = dbc
        self._by_id: dict[tuple[int, bool], Any] = {}
        self._pages: dict[str, tuple[str, _Page]] = {}
        self._sources: dict[str, list[tuple[str, _Page]]] = {}
        self._unseen: set[tuple[int, bool]] = set()
        self._others: set[tuple[int, bool]] = set()
        self.undecoded = 0
        """Frames of the DBC file that could not be decoded: too short for any signal, or without a meaning."""
        self.keep([each.name for each in self._database.messages])

    def find(self, name: str) -> tuple[str, str, str]:
        """Return frame, name within it and unit of a signal, given as SIGNAL or FRAME.SIGNAL.

        A signal that only some pages of a multiplexed frame have comes from these pages.

        Raises:
            ValueError: there is no such signal, or several; the text names those there are.
        """
        signals = [(frame.name, each) for frame in self._database.messages for each in frame.signals]
        found = [(frame, each) for frame, each in signals if name in (each.name, f"{frame}.{each.name}")]
        if len(found) > 1:
            several = ", ".join(f"{frame}.{each.name}" for frame, each in found)
            raise ValueError(f"several CAN signals have the name '{name}': {several}")
        if not found:
            names = list(dict.fromkeys(each.name for _, each in signals))
            near = get_close_matches(name, names, _MOST_LISTED, 0.4) or sorted(names)[:_MOST_LISTED]
            more = f", and {len(names) - len(near)} more" if len(near) < len(names) else ""
            raise ValueError(f"{self._path} has no CAN signal '{name}': there are {', '.join(near)}{more}")
        frame, signal = found[0]
        source, page = frame, _Page("")
        if signal.multiplexer_ids:
            page = _Page(signal.multiplexer_signal or "", tuple(signal.multiplexer_ids))
            source = f"{frame}{PAGE}{'/'.join(str(each) for each in page.pages)}"
        self._pages[source] = frame, page
        return source, signal.name, signal.unit or ""

    def keep(self, names: Collection[str]) -> None:
        """Decode these sources only, which `find` returned, or frames.

        Raises:
            ParameterError: the DBC file contradicts itself in one of their frames.
        """
        self._sources = {}
        for name in names:
            frame, page = self._pages.get(name, (name, _Page("")))
            self._sources.setdefault(frame, []).append((name, page))
        kept = [each for each in self._database.messages if each.name in self._sources]
        self._by_id = {(each.frame_id, each.is_extended_frame): each for each in kept}
        self._unseen = set(self._by_id)
        if self.notes and len(kept) < len(self._database.messages):
            for each in kept:
                try:
                    each.refresh(strict=True)
                except Exception as error:  # cantools passes on whatever its checks raise
                    raise ParameterError(f"DBC file {self._path}: {error}") from error

    def decode(self, frame_id: int, is_extended: bool, data: bytes) -> list[Frame]:
        """Decode a frame, as far as it goes; nothing for one that is not kept, or that cannot be decoded."""
        key = frame_id, is_extended
        message = self._by_id.get(key)
        if message is None:
            self._others.add(key)
            return []
        self._unseen.discard(key)
        try:
            values = message.decode(data, decode_choices=False, allow_truncated=True)
        except Exception:  # cantools passes on errors of its bit reader
            values = {}
        if not values:
            self.undecoded += 1
            return []
        return [
            Frame(source, message.name, values)
            for source, page in self._sources[message.name]
            if not page.multiplexer or values.get(page.multiplexer) in page.pages
        ]

    def not_in_log(self) -> list[str]:
        """Return a sentence for each frame that has not come, with the identifier that is nearest to its own."""
        texts = []
        for key in sorted(self._unseen):
            near = min(self._others, key=lambda other: _unlike(key, other), default=None)
            nearest = f"; the nearest that is there is {_identifier(near)}" if near else ""
            texts.append(f"frame {self._by_id[key].name} ({_identifier(key)}) is not in the log{nearest}")
        return texts


_EXTRA = re.compile(r"(?:SG_MUL_VAL_|SIG_VALTYPE_) (\d+) ")
"""Lines of a DBC file that say more of the signals of a frame."""
_FRAME = re.compile(r"BO_ (\d+) (\w+).*(?:\n[ \t]+SG_ .*)*", re.ASCII)
"""A frame with its signals."""
_MOST_NAMED = 5


def _read(load_file: Callable[..., Any], load_string: Callable[..., Any], dbc: Path) -> tuple[Any, tuple[str, ...]]:
    """Return the database of a DBC file, and what contradicts itself in it, which is no reason not to read the rest."""
    try:
        return load_file(dbc), ()
    except OSError:
        raise
    except Exception as unsound:  # cantools passes on whatever its parsers raise
        note = f"DBC file {dbc}: {unsound}; only the frames that the map names must be sound"
    try:
        return load_file(dbc, strict=False), (note,)
    except Exception as error:  # as above
        database, left_out = _frame_by_frame(load_string, dbc.read_text(encoding="cp1252", errors="replace"))
        if not database.messages:
            raise error
        if left_out:
            more = f" and {len(left_out) - _MOST_NAMED} more" if len(left_out) > _MOST_NAMED else ""
            note += f"; left out: {', '.join(left_out[:_MOST_NAMED])}{more}"
        return database, (note,)


def _frame_by_frame(load_string: Callable[..., Any], text: str) -> tuple[Any, list[str]]:
    """Return a database of the frames of a DBC file that can be read, and the names of the others."""
    text = text.replace("\r", "")
    sound: dict[str, str] = {}
    left_out = []
    for found in _FRAME.finditer(text):
        try:
            load_string(_dbc([found[0]]), database_format="dbc", strict=False)
            sound[found[1]] = found[0]
        except Exception:  # as above
            left_out.append(found[2])
    extra = [line for line in text.splitlines() if (match := _EXTRA.match(line)) and match[1] in sound]
    return load_string(_dbc([*sound.values(), *extra]), database_format="dbc", strict=False), left_out


def _dbc(parts: Iterable[str]) -> str:
    return "\n\n".join(['VERSION ""', "BU_:", *parts]) + "\n"


def _unlike(key: tuple[int, bool], other: tuple[int, bool]) -> tuple[bool, int, int]:
    """Return how far an identifier is from another; those of J1939 that differ in the source address are near."""
    return key[1] != other[1], (key[0] ^ other[0]) >> 8 & 0x3FFFF, abs(key[0] - other[0])


def _identifier(key: tuple[int, bool]) -> str:
    return f"{key[0]:08X}" if key[1] else f"{key[0]:03X}"


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
