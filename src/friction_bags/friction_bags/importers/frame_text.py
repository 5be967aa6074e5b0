"""Reads CAN frames from texts that python-can does not: CSV of SavvyCAN and GVRET, BUSMASTER, and what candump prints.

candump prints `(stamp)  bus  identifier  [length]  bytes`, with stamps since 1970 (-ta, and -tA as a date), since the
beginning (-tz) or since the line before (-td), and none by default.
"""

import csv
import re
from collections.abc import Iterator
from datetime import datetime, timezone
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Final, TextIO

from friction_bags.bag_io.bag_format import BagError

GVRET_BEGIN: Final = "time stamp,id,extended,"
"""Begin of the first line of a GVRET table, in small letters."""
_PRINTED: Final = re.compile(
    r"\s*(?:\((?P<stamp>[^)]*)\))?\s*(?P<bus>\w+)\s+(?:[RT]X\s+\S+\s+\S+\s+)?(?P<id>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})"
    r"\s+\[(?P<length>\d+)\](?P<data>(?:\s+[0-9A-Fa-f]{2})*|\s+remote request.*)"
)
BUSMASTER_BEGIN: Final = "***BUSMASTER"
_BUSMASTER: Final = re.compile(
    r"(?P<hour>\d+):(?P<minute>\d\d):(?P<second>\d\d):(?P<part>\d+)\s+[RT]x\s+(?P<bus>\w+)\s+(?P<id>(0x)?[0-9A-Fa-f]+)\s+"
    r"(?P<kind>[sx])(?P<remote>r?)\s+(?P<length>\d+)(?P<data>(?:\s+[0-9A-Fa-f]+)*)\s*$"
)
_LOOKED_AT: Final = 200
"""Frames by which stamps since the line before are told from those since the beginning."""
_MICROSECONDS: Final = 1e-6


def is_printed(line: str) -> bool:
    """Whether a line is one that candump prints."""
    return _PRINTED.match(line) is not None


class FrameText:
    """Frames of a text, as python-can's readers yield them."""

    def __init__(self, path: Path) -> None:
        """Open the file.

        Raises:
            ImportError: python-can is not installed.
            OSError: it cannot be read.
        """
        import can

        self._message = can.Message
        self._path = path
        self.file: TextIO = path.open(encoding="utf-8-sig", errors="replace", newline="")
        self.unread = 0
        """Lines that are no frame."""
        self.is_cut_off = False
        """Whether the last line has no end."""

    def __iter__(self) -> Iterator[Any]:
        """Yield the frames.

        Raises:
            BagError: the frames have no stamps.
        """
        first = self.file.readline()
        self.file.seek(0)
        if first.startswith(BUSMASTER_BEGIN):
            return self._of_busmaster()
        return self._of_table() if first.lower().startswith(GVRET_BEGIN) else self._of_print()

    def __enter__(self) -> "FrameText":
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close the file."""
        self.file.close()

    def _lines(self) -> Iterator[str]:
        for line in self.file:
            self.is_cut_off = not line.endswith("\n")
            yield line

    def _frame(
        self, time: float, bus: str | None, identifier: int, is_extended: bool, data: bytes, length: int | None
    ) -> Any:
        """Return a frame; without a length it is a remote one.

        Raises:
            ValueError: it is none.
        """
        if length is not None and len(data) != length:
            raise ValueError(f"{len(data)} bytes, and {length} are stated")
        return self._message(
            timestamp=time,
            arbitration_id=identifier,
            is_extended_id=is_extended,
            is_remote_frame=length is None,
            channel=bus,
            data=data,
            is_fd=len(data) > 8,
        )

    def _of_table(self) -> Iterator[Any]:
        names = [name.strip().lower() for name in self.file.readline().split(",")]
        at = {name: place for place, name in enumerate(names)}
        data = at.get("d1", len(names))
        for cells in csv.reader(line.replace("\0", "") for line in self._lines()):
            try:
                length = int(cells[at["len"]])
                yield self._frame(
                    float(cells[at["time stamp"]]) * _MICROSECONDS,
                    cells[at["bus"]].strip() if "bus" in at else None,
                    int(cells[at["id"]], 16),
                    cells[at["extended"]].strip().lower() in ("true", "1"),
                    bytes(int(cell, 16) for cell in cells[data : data + length]),
                    length,
                )
            except (ValueError, LookupError):
                self.unread += bool(cells)

    def _of_busmaster(self) -> Iterator[Any]:
        """Yield the frames; the stamps are times of the day, since the beginning, or since the line before."""
        base, is_since_last, time = 16, False, 0.0
        for line in self._lines():
            if line.startswith("***"):
                base = 10 if line.startswith("***DEC") else base
                is_since_last = is_since_last or line.startswith("***RELATIVE")
                continue
            found = _BUSMASTER.match(line)
            if found is None:
                self.unread += bool(line.strip())
                continue
            try:
                stamp = 3600 * int(found["hour"]) + 60 * int(found["minute"]) + int(found["second"])
                stamp += int(found["part"]) / 10 ** len(found["part"])
                frame = self._frame(
                    time + stamp if is_since_last else stamp,
                    found["bus"],
                    int(found["id"].removeprefix("0x"), base),
                    found["kind"] == "x",
                    bytes(int(each, base) for each in found["data"].split()),
                    None if found["remote"] else int(found["length"]),
                )
            except ValueError:
                self.unread += 1
                continue
            time = frame.timestamp
            yield frame

    def _of_print(self) -> Iterator[Any]:
        is_since_last = _is_since_last(self._path)
        time = 0.0
        for line in self._lines():
            found = _PRINTED.match(line)
            if found is None:
                self.unread += bool(line.strip())
                continue
            if found["stamp"] is None:
                raise BagError(f"{self._path}: its frames have no times: log with `candump -L` or `candump -ta`")
            data = found["data"].split()
            is_remote = data[:1] == ["remote"]
            try:
                stamp = _stamp(found["stamp"])
                time = time + stamp if is_since_last else stamp
                yield self._frame(
                    time,
                    found["bus"],
                    int(found["id"], 16),
                    len(found["id"]) > 3,
                    b"" if is_remote else bytes.fromhex("".join(data)),
                    None if is_remote else int(found["length"]),
                )
            except ValueError:
                self.unread += 1


def _stamp(text: str) -> float:
    """Return a stamp in seconds.

    Raises:
        ValueError: it is none.
    """
    if "-" not in text:
        return float(text)
    return datetime.strptime(text.strip(), "%Y-%m-%d %H:%M:%S.%f").replace(tzinfo=timezone.utc).timestamp()


def _is_since_last(path: Path) -> bool:
    """Whether stamps begin at zero and often fall: they count from the line before."""
    stamps: list[float] = []
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        for line in lines:
            found = _PRINTED.match(line)
            try:
                stamps += [_stamp(found["stamp"])] if found is not None and found["stamp"] else []
            except ValueError:
                continue
            if len(stamps) == _LOOKED_AT:
                break
    falls = sum(later < sooner for sooner, later in pairwise(stamps))
    return bool(stamps) and stamps[0] == 0.0 and falls > len(stamps) / 10
