"""Frames of a CAN bus as signals, by a DBC file. cantools is needed only where a map names CAN signals."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError

INSTALL_LINE = install_line("cantools")
_MOST_LISTED = 30


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
