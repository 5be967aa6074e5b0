"""Tables, CSV and Parquet, as messages by a signal map."""

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime, timezone
from itertools import pairwise
from math import isfinite, nan
from pathlib import Path
from statistics import median
from typing import Any, Final, TextIO

import numpy as np

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import ARRIVAL, Kind, SignalMap
from friction_adapter.sources import TABLE, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.can_log import start_offset
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output

_DELIMITERS: Final = ",;\t"
_TIME: Final = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(\.\d+)?(Z|[+-]\d\d:?\d\d)?$")
"""A date with a time of day, parts of a second and a zone; without a zone it is that of UTC."""
PARQUET = ".parquet"
INSTALL_LINE = install_line("pyarrow")
_STEPS: Final = 20
"""Rows by which the unit of the stamps is judged."""
_FASTEST, _SLOWEST = 5e-5, 2.0
"""Least and largest time between two rows of a drive [s]."""
_UNITS: Final = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "days": 86400.0}
"""In which other tools write times, in seconds."""
_ROWS = 10_000
"""Rows that are read at once."""


class Table:
    """A table, read through a signal map."""

    def __init__(self, path: Path, signal_map: SignalMap) -> None:
        """Find the columns of the map.

        Raises:
            BagError: the table is empty.
            OSError: it cannot be read.
            ParameterError: a column is not there, or the map has signals from elsewhere; the text names the columns.
        """
        self._path = path
        self._map = signal_map
        with path.open("rb") as binary:
            head, self._encoding = _text(binary.readline())
        if not head.strip():
            raise BagError(f"{path} is empty: its first line must name the columns")
        self._delimiter = max(_DELIMITERS, key=head.count)
        self._has_decimal_commas = self._delimiter == ";"
        names = next(csv.reader([head.strip().lstrip("# ")], delimiter=self._delimiter, skipinitialspace=True))
        self._columns = [name.strip() for name in names]
        self._needed = columns_of(signal_map)
        self._size = max(path.stat().st_size, 1)
        self._stream: TextIO | None = None
        self._mapper = RecordMapper(signal_map, Sources(columns=self._columns))

    def rows(self) -> Iterator[dict[str, float]]:
        """Yield the rows as numbers by column, those of the map only; NaN where a cell is empty.

        Raises:
            BagError: a value is not a number; the text names line and column.
        """
        has_begun = False
        with self._path.open(newline="", encoding=self._encoding, errors="replace") as stream:
            self._stream = stream
            stream.readline()
            reader = csv.DictReader(stream, self._columns, delimiter=self._delimiter, skipinitialspace=True)
            for row in reader:
                found = {column: _number(row[column], self._has_decimal_commas) for column in self._needed}
                if not has_begun and not any(number is not None and isfinite(number) for number in found.values()):
                    continue  # units
                has_begun = True
                wrong = [column for column, number in found.items() if number is None]
                if wrong:
                    told = f"'{wrong[0]}' is '{row[wrong[0]]}': a value is not a number"
                    raise BagError(f"{self._path}, line {reader.line_num + 1}: {told}")
                yield {column: number for column, number in found.items() if number is not None}

    def of_row(self, row: Mapping[str, float]) -> list[Output]:
        """Return relative topics and messages of a row."""
        return self._mapper.take(TABLE, row, 0)

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages of all rows.

        Raises:
            BagError: a value is not a number; the text names line and column.
        """
        for row in put_later(self.rows(), self._map):
            for topic, message in self.of_row(row):
                yield f"/{topic}", message

    def share(self) -> float:
        """Return the share of the table that has been read."""
        stream = self._stream
        return 0.0 if stream is None or stream.closed else stream.buffer.tell() / self._size

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._mapper.problems_at_end()


def put_later(rows: Iterable[dict[str, float]], signal_map: SignalMap) -> Iterator[dict[str, float]]:
    """Yield the rows of a table, 1000 s later where it begins before 1 s and the map has no offset: 0 s is no stamp."""
    columns = {signal.stamp for signal in signal_map.signals if signal.origin.kind is Kind.TABLE}
    offset = 0.0 if signal_map.stamp_offset else nan
    clock = min(columns, default="")
    earlier: list[float] = []
    for row in rows:
        if len(earlier) < _STEPS:
            earlier.append(row.get(clock, nan))
            if len(earlier) == _STEPS:
                _refuse_other_unit(signal_map, clock, earlier)
        if not isfinite(offset):
            offset = max((start_offset(row[column]) for column in columns), default=0)
        yield {**row, **{column: row[column] + offset for column in columns}} if offset else row


def _refuse_other_unit(signal_map: SignalMap, column: str, stamps: Sequence[float]) -> None:
    """Refuse stamps [s] that are so far apart, or so near, that they are in another unit.

    Raises:
        BagError: the text names the unit that they may be in.
    """
    steps = [later - sooner for sooner, later in pairwise(stamps) if later > sooner]
    step = median(steps) if steps else nan
    unit = next((name for name, seconds in _UNITS.items() if _FASTEST <= step * seconds <= _SLOWEST), "")
    if isfinite(step) and unit != "s":
        told = f": is it in {unit}? Times are in seconds" if unit else ": times are in seconds"
        raise BagError(f"{signal_map.path}: the times in column '{column}' are {step:g} s apart{told}")


def columns_of(signal_map: SignalMap) -> tuple[str, ...]:
    """Return the columns of a table that a map names, each once.

    Raises:
        ParameterError: a row of a table has no time of arrival.
    """
    found: dict[str, None] = {}
    for signal in signal_map.signals:
        if signal.origin.kind is not Kind.TABLE:
            continue  # refused where it is looked for
        if signal.stamp == ARRIVAL:
            raise ParameterError(
                f"{signal_map.path}: line {signal.line}: a table needs 'stamp', the column of its time"
            )
        flag = () if signal.flag is None else (signal.flag.field,)
        found.update(dict.fromkeys((signal.stamp, *signal.fields, *flag)))
    return tuple(found)


def _text(head: bytes) -> tuple[str, str]:
    """Return a line as text, and the encoding of the file."""
    try:
        return head.decode("utf-8-sig"), "utf-8-sig"
    except UnicodeDecodeError:
        return head.decode("latin-1"), "latin-1"


def _number(cell: str | None, has_decimal_commas: bool = False) -> float | None:
    """Return the number in a cell, that of seconds where it is a time, NaN where it is empty; None for a text.

    Where semicolons separate the cells, a comma in a number is its decimal point.
    """
    if cell is None:
        return None
    if has_decimal_commas and cell.count(",") == 1 and "." not in cell:
        cell = cell.replace(",", ".")
    try:
        return float(cell)
    except ValueError:
        if not cell.strip():
            return nan
    time = _TIME.match(cell.strip())
    if time is None:
        return None
    date, clock, part, zone = time.groups()
    offset = (zone or "+00:00").replace("Z", "+00:00")
    try:
        whole = datetime.strptime(f"{date} {clock} {offset}", "%Y-%m-%d %H:%M:%S %z").astimezone(timezone.utc)
    except ValueError:
        return None
    return whole.timestamp() + float(part or 0.0)


class ParquetTable:
    """A table, read through a signal map."""

    def __init__(self, path: Path, signal_map: SignalMap) -> None:
        """Find the columns of the map.

        Raises:
            BagError: the table cannot be read.
            OSError: there is no such file.
            ParameterError: pyarrow is not installed, a column is not there, or the map has signals from elsewhere; the
                text names the columns.
        """
        try:
            from pyarrow import parquet
        except ImportError as error:
            raise ParameterError(f"Parquet tables need one more package: {INSTALL_LINE}") from error
        path.stat()
        self._path = path
        self._map = signal_map
        try:
            self._file: Any = parquet.ParquetFile(path)
        except Exception as error:  # pyarrow passes on whatever its readers raise
            raise BagError(f"{path} cannot be read: {error}") from error
        self._needed = columns_of(signal_map)
        self._mapper = RecordMapper(signal_map, Sources(columns=self._file.schema_arrow.names))
        self._read = 0

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages of all rows; an empty cell is a value that there is not.

        Raises:
            BagError: a column does not hold numbers, or the file cannot be read to its end.
        """
        for row in put_later(self._rows(), self._map):
            for topic, message in self._mapper.take(TABLE, row, 0):
                yield f"/{topic}", message

    def _rows(self) -> Iterator[dict[str, float]]:
        try:
            for batch in self._file.iter_batches(_ROWS, columns=list(self._needed)):
                columns = [self._numbers(name, batch.column(name)) for name in self._needed]
                for values in zip(*columns, strict=True):
                    yield dict(zip(self._needed, values, strict=True))
                self._read += batch.num_rows
        except OSError as error:
            raise BagError(f"{self._path} cannot be read to its end: {error}") from error

    def share(self) -> float:
        """Return the share of the table that has been read."""
        return self._read / max(int(self._file.metadata.num_rows), 1)

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._mapper.problems_at_end()

    def _numbers(self, name: str, column: Any) -> list[float]:
        values = column.to_numpy(zero_copy_only=False)
        if np.issubdtype(values.dtype, np.datetime64):
            return [float(each) for each in values.astype("datetime64[ns]").astype(np.int64) / 1e9]
        try:
            return [float(each) for each in values.astype(np.float64)]
        except (TypeError, ValueError):
            raise BagError(f"{self._path}: column '{name}' does not hold numbers") from None
