"""Reads the stamps of an ASC log as times since its beginning, for either kind that its header may name.

`timestamps relative` in the header means that each stamp counts from the line before. python-can takes it for a time
since the beginning, and passes over lines whose stamp is negative, so all are put later by `LATER`.
"""

import io
import re
from pathlib import Path
from typing import Any, Final

LATER: Final = 1000
"""What is added to all stamps [s]."""
_RELATIVE: Final = re.compile(r"base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)
_STAMP: Final = re.compile(r"\s*(-?\d+\.\d+)(?=\s)")


class AscStamps(io.TextIOBase):
    """Lines of a log, their stamps put later and summed up where they are relative."""

    def __init__(self, path: Path) -> None:
        """Open a log.

        Raises:
            OSError: it cannot be read.
        """
        self._lines = path.open(encoding="utf-8", errors="replace")
        self._is_relative = False
        self._sum = 0.0

    @property
    def buffer(self) -> Any:
        """The file in bytes, which knows how far it has been read."""
        return self._lines.buffer

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        """Return the next line."""
        line = self._lines.readline(size)
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
