"""Tables as text: encoding, separator, lines before the names of the columns, and numbers as other tools write them."""

import csv
import re
from codecs import getincrementaldecoder
from collections.abc import Collection, Iterator
from datetime import datetime, timezone
from itertools import islice
from math import nan
from pathlib import Path
from typing import Final, TextIO

from friction_adapter.stamp_unit import STAMP_UNITS
from friction_bags.bag_io.bag_format import BagError

_DELIMITERS: Final = ",;\t| "
"""What separates cells; blanks only where nothing else does."""
_DATE: Final = r"(?:(\d{4})[-/](\d\d?)[-/](\d\d?)|(\d\d?)\.(\d\d?)\.(\d{4}))[T ]\s*"
"""Year first, or the day first with points: what has slashes and ends with the year is one of two days."""
_TIME: Final = re.compile(rf"(?:{_DATE})?(\d\d?):(\d\d):(\d\d)([.,]\d+)?\s*(Z|[+-]\d\d:?\d\d)?$")
"""A time of day, with a date or alone; without a zone it is that of UTC."""
_GROUPED: Final = re.compile(r"[+-]?\d{1,3}(\.\d{3})+,\d+$")
"""A number with points between its thousands."""
_HEAD_BYTES, _HEAD_LINES = 1 << 17, 200
"""How far the names of the columns are looked for."""


class TextTable:
    """A table whose cells are text."""

    def __init__(self, path: Path, wanted: Collection[str]) -> None:
        """Find the names of the columns: the first line that has the wanted ones, or most of them.

        Raises:
            BagError: the table is empty.
            OSError: it cannot be read.
        """
        self._path = path
        with path.open("rb") as binary:
            head = binary.read(_HEAD_BYTES)
        if not head.strip(b" \r\n\t\0"):
            raise BagError(f"{path} is empty: a line must name the columns")
        self._encoding = _encoding(head)
        lines = head.decode(self._encoding, errors="replace").splitlines()[:_HEAD_LINES]
        self._delimiter, self._before, self.columns = _header(lines, frozenset(wanted))
        self.units: dict[str, str] = {}
        """Units of the columns, where a line below their names has them."""
        self.is_cut_off = False
        """Whether the last line has no end; it is no row then, as its last number may be half of one."""
        self._has_decimal_commas = self._delimiter != ","
        self._size = max(path.stat().st_size, 1)
        self._stream: TextIO | None = None
        self._has_ended = True
        """Whether the line that was read last has its end."""

    def rows(self, needed: Collection[str]) -> Iterator[tuple[int, dict[str, float], dict[str, str]]]:
        """Yield line, numbers and texts of the needed columns; NaN where a cell is empty or a text.

        Lines before the first number, such as those of units, are no rows.

        Raises:
            BagError: a line cannot be read.
        """
        places = [(column, self.columns.index(column)) for column in needed]
        has_begun = False
        with self._path.open(newline="", encoding=self._encoding, errors="replace") as stream:
            self._stream = stream
            for _ in islice(stream, self._before + 1):
                pass
            reader = csv.reader(self._lines(stream), delimiter=self._delimiter, skipinitialspace=True)
            try:
                for cells in reader:
                    if not any(map(str.strip, cells)):
                        continue
                    if not self._has_ended:
                        self.is_cut_off = True
                        continue
                    row: dict[str, float] = {}
                    texts: dict[str, str] = {}
                    for column, place in places:
                        cell = cells[place] if place < len(cells) else ""
                        number = number_in(cell, self._has_decimal_commas)
                        row[column] = nan if number is None else number
                        if number is None:
                            texts[column] = cell.strip()
                    if not has_begun and not any(number == number for number in row.values()):
                        self.units.update((name, text) for name, text in texts.items() if text in STAMP_UNITS)
                        continue
                    has_begun = True
                    yield self._before + 1 + reader.line_num, row, texts
            except csv.Error as error:
                line = self._before + 1 + reader.line_num
                raise BagError(f"{self._path}, line {line}: cannot be read: {error}") from error

    def share(self) -> float:
        """Return the share of the file that has been read."""
        stream = self._stream
        return 0.0 if stream is None or stream.closed else min(stream.buffer.tell() / self._size, 1.0)

    def _lines(self, stream: TextIO) -> Iterator[str]:
        """Yield the lines; a zero byte, which a full disk leaves, is none of a text."""
        for line in stream:
            self._has_ended = line.endswith(("\n", "\r"))
            yield line.replace("\0", "")


def number_in(cell: str, has_decimal_commas: bool = False) -> float | None:
    """Return the number in a cell, that of seconds where it is a time, NaN where it is empty; None for a text.

    Args:
        cell: the cell.
        has_decimal_commas: whether a comma in a number is its decimal point; else it is none of a number.
    """
    if has_decimal_commas and "," in cell:
        cell = cell.replace(".", "") if _GROUPED.match(cell.strip()) else cell
        cell = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return nan if not cell.strip() else _time_in(cell.strip())


def _time_in(cell: str) -> float | None:
    """Return seconds since 1970, since midnight where there is no date; None for what is no time."""
    found = _TIME.match(cell)
    if found is None:
        return None
    year, month, day, day_first, month_first, year_last, hour, minute, second, part, zone = found.groups()
    rest = float((part or ".0").replace(",", "."))
    if year is None and year_last is None:
        return int(hour) * 3600 + int(minute) * 60 + int(second) + rest
    date = f"{year or year_last}-{month or month_first}-{day or day_first}"
    offset = (zone or "+00:00").replace("Z", "+00:00")
    try:
        whole = datetime.strptime(f"{date} {hour}:{minute}:{second} {offset}", "%Y-%m-%d %H:%M:%S %z")
    except ValueError:
        return None
    return whole.astimezone(timezone.utc).timestamp() + rest


def _encoding(head: bytes) -> str:
    """Return the encoding of a file that begins like this."""
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if head[1:8:2] == bytes(4) or head[:8:2] == bytes(4):  # letters of two bytes, without their mark
        return "utf-16-le" if head[1] == 0 else "utf-16-be"
    try:
        getincrementaldecoder("utf-8")().decode(head)  # the last letter may be cut off
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8-sig"


def _header(lines: list[str], wanted: frozenset[str]) -> tuple[str, int, list[str]]:
    """Return the separator, the number of lines before that of the names, and the names."""
    best: tuple[tuple[int, bool, int], str, int, list[str]] | None = None
    for number, line in enumerate(lines):
        for delimiter in _DELIMITERS:
            try:
                cells = next(csv.reader([line.strip().lstrip("# ")], delimiter=delimiter, skipinitialspace=True), [])
            except csv.Error:
                continue
            names = [cell.strip() for cell in cells]
            if len(names) > 1 and all(number_in(name) is not None for name in names):
                continue  # numbers are no names
            rank = len(wanted.intersection(names)), delimiter != " ", len(names)
            if names and (best is None or rank > best[0]):
                best = rank, delimiter, number, names
    return (",", 0, []) if best is None else best[1:]
