"""Messages of one class from and to CDR by their layouts."""

from collections.abc import Callable
from contextlib import suppress
from operator import attrgetter
from typing import Any, Final

from friction_runtime.cdr_layout import HEADER, Layout, Message, UnsupportedFieldError

_LENGTH_SIZE: Final = 4
_MOST_LAYOUTS: Final = 64
"""Most layouts kept of one class before all are dropped, so that strings of ever new lengths do not fill the memory."""


class LayoutCodec:
    """Reads and writes what a layout covers, in a fraction of the time of libraries that go field by field."""

    def __init__(self, kind: Any, made_as: Callable[[Any], Any]) -> None:
        """Start without a layout.

        Args:
            kind: generated message class.
            made_as: returns the class of what is made of a message of a class; it has the same fields.
        """
        self._made_as = made_as
        self._layouts: dict[tuple[int, ...], Layout] = {}
        self._first_length = 0
        self._tried: dict[tuple[int, bytes], Layout] = {}
        """The layout that fitted last, by size and first length of the data."""
        self._message: Message | None = None
        self._values_of: Callable[[Any], tuple[Any, ...]] | None = None
        self._texts: list[int] = []
        with suppress(UnsupportedFieldError):
            self._message = Message(kind)
            slots = list(self._message.written_slots())
            self._texts = [index + 1 for index in range(1, len(slots)) if slots[index] == slots[index - 1]]
            """Places of the texts in Layout.write."""
            if len(slots) > 1:
                self._values_of = attrgetter(*slots)

    def write(self, message: Any) -> bytes | None:
        """Return the CDR of a message, little endian, with zeros between fields; None where that is not covered.

        Raises:
            struct.error: a number is out of its range.
        """
        if self._values_of is None or self._message is None:
            return None
        values = [HEADER, *self._values_of(message)]
        lengths = []
        for index in self._texts:
            text = values[index].encode()
            length = len(text) + 1
            values[index - 1] = length
            values[index] = text
            lengths.append(length)
        return self._layout(self._message, tuple(lengths)).write(values)

    def read(self, data: bytes) -> Any:
        """Return a message whose lengths are those of an earlier one, see `learn`; None where they are not."""
        known = self._tried.get(self._key(data))
        if known is None:
            return None
        try:
            return known.read(data)
        except ValueError:
            return None

    def learn(self, data: bytes, message: Any) -> None:
        """Take the lengths of a message that another library has read from the data."""
        if self._message is None:
            return
        layout = self._layout(self._message, tuple(self._message.lengths(message)))
        if layout.size == len(data):
            self._first_length = layout.first_length
            self._tried[self._key(data)] = layout

    def _key(self, data: bytes) -> tuple[int, bytes]:
        return len(data), data[self._first_length : self._first_length + _LENGTH_SIZE]

    def _layout(self, message: Message, lengths: tuple[int, ...]) -> Layout:
        layout = self._layouts.get(lengths)
        if layout is None:
            if len(self._layouts) == _MOST_LAYOUTS:
                self._layouts.clear()
                self._tried.clear()
            layout = self._layouts[lengths] = Layout(message, lengths, self._made_as)
        return layout
