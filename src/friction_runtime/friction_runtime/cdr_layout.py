"""CDR layout of a message, given the lengths of its strings and sequences.

The strings and sequences of a topic seldom change their lengths. As long as they do not, a whole message is one struct,
read or written at once instead of field by field. Another library reads what is not covered here, and a message whose
lengths are new (cdr_codec.py).
"""

import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from struct import Struct, calcsize
from typing import Any, Final

import numpy as np

HEADER: Final = b"\0\1\0\0"
"""Encapsulation header of little-endian CDR; alignment counts from its end."""
_TEXT: Final = "s"
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
    "string": _TEXT,
}
_DECLARED = re.compile(r"(?P<sequence>sequence<)?(?P<element>[\w/]+)(?:>|\[(?P<count>\d+)\])?")


class UnsupportedFieldError(Exception):
    """A message class has a field that is not covered, such as a sequence of messages."""


class Field:
    """A number, a string, or several of either; `name` is that in the message to which it belongs."""

    def __init__(self, name: str, code: str, count: int | None, is_sequence: bool) -> None:
        """Set the type of an element (code of the module struct) and the number in an array (None: a single one)."""
        self.name = name
        self.code = code
        self.count = count
        self.is_sequence = is_sequence

    def lengths(self, value: Any) -> Iterator[int]:
        """Yield the lengths of a value in the CDR, see Layout."""
        if self.is_sequence:
            yield len(value)
        if self.code == _TEXT:
            for text in value if self.is_sequence else (value,):
                yield len(text.encode()) + 1


class Message:
    """A message class and those within it; `name` is that in the message to which it belongs."""

    def __init__(self, kind: Any, name: str = "") -> None:
        """Read the fields of a class.

        Raises:
            UnsupportedFieldError: a field is not covered.
        """
        self.name = name
        self.kind = kind
        self.children: list[Field | Message] = []
        for each, declared in kind.get_fields_and_field_types().items():
            found = _DECLARED.fullmatch(declared)
            element = found["element"] if found else declared
            count = int(found["count"]) if found and found["count"] else None
            is_sequence = found is not None and found["sequence"] is not None
            if element in _CODES and not (count is not None and element == "string"):
                self.children.append(Field(each, _CODES[element], count, is_sequence))
            elif element == declared and "/" in element:
                self.children.append(Message(_class_named(element), each))
            else:
                raise UnsupportedFieldError(f"{kind.__name__}: {each} is {declared}")
        if not self.children:
            raise UnsupportedFieldError(f"{kind.__name__} has no fields")  # a byte stands in for them in the CDR

    def lengths(self, message: Any) -> Iterator[int]:
        """Yield the lengths of its strings and sequences in the CDR, see Layout."""
        for child in self.children:
            yield from child.lengths(getattr(message, child.name))

    def written_slots(self, prefix: str = "") -> Iterator[str]:
        """Yield the slots of the numbers and strings in the order of Layout.write; a string twice.

        Slots within messages have dotted names.

        Raises:
            UnsupportedFieldError: a field is an array or a sequence.
        """
        for child in self.children:
            slot = f"{prefix}_{child.name}"
            if isinstance(child, Message):
                yield from child.written_slots(f"{slot}.")
            elif child.is_sequence or child.count is not None:
                raise UnsupportedFieldError(f"{self.kind.__name__}: {child.name} is no single value")
            else:
                yield from (slot, slot) if child.code == _TEXT else (slot,)


def _class_named(name: str) -> Any:
    """Return the class of a message within another one, which has imported it; `name` is its package/Name."""
    package, _, own = name.partition("/")
    return getattr(import_module(f"{package}.msg"), own)


class _Numbers:
    """An array or a sequence of numbers. It stays the same array while its bytes do, as those of covariances mostly."""

    def __init__(self, code: str, count: int, begin: int) -> None:
        self._kind = np.dtype(f"<{code}")
        self._begin = begin
        self._end = begin + count * self._kind.itemsize
        self._bytes = bytes(count * self._kind.itemsize)
        self._array: Any = np.frombuffer(self._bytes, self._kind) if count else np.zeros(0, self._kind)

    def make(self, values: list[Any], data: bytes) -> Any:
        part = data[self._begin : self._end]
        if part != self._bytes:
            self._bytes = part
            self._array = np.frombuffer(part, self._kind)
        return self._array


class _Texts:
    """A sequence of strings."""

    def __init__(self, places: list[int]) -> None:
        self._places = places

    def make(self, values: list[Any], data: bytes) -> Any:
        return [values[place] for place in self._places]


class _Fields:
    """A message."""

    def __init__(self, kind: Any, places: list[tuple[str, int]]) -> None:
        self._kind = kind
        self._places = places

    def make(self, values: list[Any], data: bytes) -> Any:
        message = self._kind.__new__(self._kind)
        for name, place in self._places:
            setattr(message, name, values[place])
        return message


_Part = _Numbers | _Texts | _Fields
"""Makes a value that is not directly in the struct; these follow the values of the struct."""


class Layout:
    """The CDR of a message class with known lengths."""

    def __init__(self, message: Message, lengths: Sequence[int], made_as: Callable[[Any], Any]) -> None:
        """Compute the layout.

        Args:
            message: the class.
            lengths: lengths of its strings (bytes, with the zero at the end) and sequences (elements) in the order of
                the CDR; the number of strings in a sequence comes before their lengths.
            made_as: returns the class of what is made of a message of a class.
        """
        self._format = "<4s"
        self._position = 0
        self._expected: list[tuple[int, Any]] = [(0, HEADER)]
        self._count = 1
        self._text_places: list[int] = []
        self._parts: list[_Part] = []
        self._lengths = iter(lengths)
        self._made_as = made_as
        self.first_length = 0
        """Position of the first length in the data: the same for all layouts of a class; 0 where there is none."""
        self._root = self._message(message)
        self._blank: list[Any] = [None] * len(self._parts)
        self._struct = Struct(self._format)
        self.size = self._struct.size

    def read(self, data: bytes) -> Any:
        """Return the message from CDR of this size; None where the lengths in it differ.

        Raises:
            ValueError: a string is not UTF-8.
        """
        values: list[Any] = [*self._struct.unpack(data), *self._blank]
        for place, value in self._expected:
            if values[place] != value:
                return None
        for place in self._text_places:
            text: bytes = values[place]
            values[place] = text[:-1].decode()
        place = -1
        for part in self._parts:
            values[place] = part.make(values, data)
            place -= 1
        return values[self._root]

    def write(self, values: Sequence[Any]) -> bytes:
        """Return the CDR of HEADER and the numbers and strings (bytes) after it, each string after its length.

        Raises:
            struct.error: a number is out of its range.
        """
        return self._struct.pack(*values)

    def _message(self, message: Message) -> int:
        """Lay out a message; return its place. Parts follow the values of the struct, the outermost message last."""
        places = [
            (each.name, self._message(each) if isinstance(each, Message) else self._field(each))
            for each in message.children
        ]
        return self._part(_Fields(self._made_as(message.kind), places))

    def _field(self, field: Field) -> int:
        count = self._length() if field.is_sequence else field.count
        if count is None:
            return self._text() if field.code == _TEXT else self._value(field.code)
        if field.code == _TEXT:
            return self._part(_Texts([self._text() for _ in range(count)]))
        if count:
            self._align(field.code)
        begin = len(HEADER) + self._position
        self._skip(count * calcsize(f"<{field.code}"))
        return self._part(_Numbers(field.code, count, begin))

    def _text(self) -> int:
        place = self._value(f"{self._length()}s")
        self._text_places.append(place)
        return place

    def _length(self) -> int:
        length = next(self._lengths)
        self._expected.append((self._value("I"), length))
        if self.first_length == 0:
            self.first_length = len(HEADER) + self._position - calcsize("<I")
        return length

    def _value(self, code: str) -> int:
        """Append a value to the struct; return its place."""
        self._align(code)
        self._format += code
        self._position += calcsize(f"<{code}")
        self._count += 1
        return self._count - 1

    def _part(self, part: _Part) -> int:
        self._parts.append(part)
        return -len(self._parts)

    def _align(self, code: str) -> None:
        size = 1 if code.endswith(_TEXT) else calcsize(f"<{code}")
        self._skip(-self._position % size)

    def _skip(self, size: int) -> None:
        self._format += f"{size}x"
        self._position += size
