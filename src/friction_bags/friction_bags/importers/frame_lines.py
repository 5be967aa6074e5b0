"""Lines of a CAN log for python-can's readers, which pass over what they cannot read: those of frames are counted here.

Stamps of an ASC log are made times since its beginning: `timestamps relative` in the header means that each counts from
the line before. python-can takes it for a time since the beginning, and passes over lines whose stamp is negative, so
all are put later by `LATER`.
"""

import io
import re
from pathlib import Path
from typing import Any, Final

LATER: Final = 1000
"""What is added to all stamps of an ASC log [s]."""
_RELATIVE: Final = re.compile(r"base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)
_STAMP: Final = re.compile(r"\s*(-?\d+\.\d+)(?=\s)")
_FRAMES: Final = {
    ".asc": re.compile(r"(?!\s*\S+\s+(L|Fr|ETH))(.*\s[RT]x\s|.*\s[dr]\s+\w\s|\s*\S+\s+CANFD\s)"),
    ".csv": re.compile(r"(?!timestamp,)\s*\S"),
    ".log": re.compile(r"\s*\S"),
    ".trc": re.compile(r"(?!\s*;)(?!.*\s(ST|EC|ER|EV|RR|Error|Warng|Overload|FFFFFFFF)\s)\s*\S"),
}
"""Lines that are, or were, those of a frame."""


class FrameLines(io.TextIOBase):
    """Lines of a log."""

    def __init__(self, path: Path, kind: str) -> None:
        """Open a log.

        Args:
            path: the log.
            kind: suffix that python-can reads it by, one of .asc, .csv, .log and .trc.

        Raises:
            OSError: it cannot be read.
        """
        self._lines = path.open(encoding="utf-8", errors="replace")
        self._is_frame = _FRAMES[kind].match
        self._is_asc = kind == ".asc"
        self._is_relative = False
        self._sum = 0.0
        self.frames = 0
        """Lines of frames so far."""
        self.is_cut_off = False
        """Whether the last line has no end."""

    @property
    def buffer(self) -> Any:
        """The file in bytes, which knows how far it has been read."""
        return self._lines.buffer

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        """Return the next line."""
        line = self._lines.readline(size)
        self.is_cut_off = self.is_cut_off or (bool(line) and not line.endswith("\n"))
        self.frames += self._is_frame(line) is not None
        return self._of_beginning(line) if self._is_asc else line

    def _of_beginning(self, line: str) -> str:
        """Return a line of an ASC log with a stamp since its beginning, later by LATER."""
        self._is_relative = self._is_relative or _RELATIVE.match(line.strip()) is not None
        match = _STAMP.match(line)
        if match is None:
            return line
        stamp = float(match[1])
        self._sum = self._sum + stamp if self._is_relative else stamp
        return f"{self._sum + LATER:.9f}{line[match.end() :]}"

    def close(self) -> None:
        """Close the file."""
        self._lines.close()
        super().close()
