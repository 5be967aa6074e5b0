"""Where the fields of a message class lie in its CDR: runs of numbers, texts, arrays and sequences.

CDR aligns each number to its size. Behind a text of any length the padding is not known in advance, so that a run of
numbers has one struct for each of the eight places where it may begin.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from struct import Struct
from typing import Any

from rosidl_parser.definition import (  # type: ignore[import-untyped]
    AbstractNestedType,
    AbstractString,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

from friction_bags.message_definition import message_class

_CODES = {
    "boolean": "?",
    "double": "d",
    "float": "f",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
_SIZES = {code: Struct(f"<{code}").size for code in _CODES.values()}


class UnsupportedLayoutError(Exception):
    """A message class has fields that are not covered here."""


@dataclass(frozen=True)
class Numbers:
    """A run of numbers."""

    codes: str
    """Their struct codes, one each."""

    def structs(self) -> tuple[Struct, ...]:
        """The run as it lies behind each position modulo 8."""
        return tuple(Struct(f"<{''.join(self._padded(begin))}") for begin in range(8))

    def _padded(self, begin: int) -> Iterator[str]:
        position = begin
        for code in self.codes:
            padding = -position % _SIZES[code]
            yield "x" * padding + code
            position += padding + _SIZES[code]


@dataclass(frozen=True)
class Text:
    """A string."""


@dataclass(frozen=True)
class Texts:
    """A sequence of strings."""


@dataclass(frozen=True)
class FixedArray:
    """An array of so many numbers."""

    code: str
    count: int


@dataclass(frozen=True)
class NumberSequence:
    """A sequence of numbers."""

    code: str

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return _SIZES[self.code]


Item = Numbers | Text | Texts | FixedArray | NumberSequence


@dataclass(frozen=True)
class Shape:
    """A message class as a tree: which values of the flat list are its own, which make its messages."""

    kind: Any
    values: tuple[tuple[str, int], ...]
    """Slot and index in the flat list."""
    messages: tuple[tuple[str, "Shape"], ...]
    """Slot and shape."""


@dataclass(frozen=True)
class Layout:
    """A message class in CDR."""

    items: tuple[Item, ...]
    """In their order; a run of numbers holds as many values as it has codes, the others one."""
    paths: tuple[str, ...]
    """Slots of the values in their order, dotted where they lie in a message within."""
    shape: Shape


def layout_of(kind: Any) -> Layout:
    """Layout of a message class.

    Raises:
        UnsupportedLayoutError: it has fields that are not covered, such as sequences of messages.
    """
    fields: list[Item] = []
    paths: list[str] = []
    shape = _walk(kind, "", fields, paths)
    items: list[Item] = []
    for item in fields:
        if isinstance(item, Numbers) and items and isinstance(items[-1], Numbers):
            items[-1] = Numbers(items[-1].codes + item.codes)
        else:
            items.append(item)
    return Layout(tuple(items), tuple(paths), shape)


def _walk(kind: Any, prefix: str, fields: list[Item], paths: list[str]) -> Shape:
    values: list[tuple[str, int]] = []
    messages: list[tuple[str, Shape]] = []
    for name, declared in zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True):
        slot = f"_{name}"
        if isinstance(declared, NamespacedType):
            inner = message_class("/".join(declared.namespaced_name()))
            messages.append((slot, _walk(inner, f"{prefix}{slot}.", fields, paths)))
            continue
        values.append((slot, len(paths)))
        paths.append(prefix + slot)
        fields.append(_item(declared, f"{kind.__name__}.{name}"))
    return Shape(kind, tuple(values), tuple(messages))


def _item(declared: Any, name: str) -> Item:
    if isinstance(declared, BasicType) and declared.typename in _CODES:
        return Numbers(_CODES[declared.typename])
    if isinstance(declared, AbstractString):
        return Text()
    if isinstance(declared, AbstractNestedType) and not isinstance(declared, BoundedSequence):
        element = declared.value_type
        if isinstance(element, BasicType) and element.typename in _CODES and element.typename != "boolean":
            code = _CODES[element.typename]
            return FixedArray(code, declared.size) if isinstance(declared, Array) else NumberSequence(code)
        if isinstance(element, AbstractString) and not isinstance(declared, Array):
            return Texts()
    raise UnsupportedLayoutError(f"{name}: {declared}")
