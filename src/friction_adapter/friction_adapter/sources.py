"""Sources of signals: fields of messages, frames of a CAN bus, columns of a table."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Protocol

from friction_adapter.field_path import FieldPath, Fields
from friction_adapter.signal_map import Kind, Origin

TABLE = "table"
"""Name of the only source of a table."""
Read = Callable[[Any], Any]


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
