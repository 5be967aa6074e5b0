"""Paths of fields in messages: `a.b`, `a[2]`, `velocity[name=wheel_fl]`, `wheels[id=3].speed`.

`x[key=value]` picks by name. Where the elements of `x` are messages, it is the first whose field `key` has the value;
else it is the element of `x` at the place that the value has in the sequence `key` beside `x`, as in a JointState.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

_STEP = re.compile(r"([A-Za-z]\w*)(?:\[(?:(\d+)|([A-Za-z]\w*)=([^\[\]=]+))\])?", re.ASCII)


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
