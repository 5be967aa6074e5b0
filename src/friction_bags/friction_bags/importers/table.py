"""Tables, CSV and Parquet, as messages by a signal map."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain, islice
from math import isfinite
from pathlib import Path
from typing import Any, Final

import numpy as np

from friction_adapter.ros.messages import RecordMapper
from friction_adapter.signal_map import ARRIVAL, Kind, SignalMap
from friction_adapter.sources import TABLE, Sources
from friction_adapter.stamp_unit import TIME_COLUMNS, is_step, nanoseconds_of, unit_by_name, unit_by_steps
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.start_offset import start_offset
from friction_bags.importers.text_table import TextTable
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS

PARQUET: Final = ".parquet"
INSTALL_LINE: Final = install_line("pyarrow")
_LOOKED_AT: Final = 50
"""Rows by which the unit of the stamps is judged."""
_ROWS: Final = 10_000
"""Rows that are read at once."""
_NO_STAMP: Final = "header.stamp"
"""Stamp of a map that names none."""
Row = dict[str, float]


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
        self._text = TextTable(path, columns_of(signal_map))
        self._rows = _MappedRows(path, signal_map, self._text.columns)
        self._texts: dict[str, tuple[str, int]] = {}
        """First text in place of a number, and how many there are, by column."""

    def rows(self) -> Iterator[Row]:
        """Yield the rows as numbers by column, those of the map only; NaN where a cell is empty or a text."""
        for line, row, texts in self._text.rows(self._rows.needed):
            for column, text in texts.items():
                first, count = self._texts.get(column, (f"line {line}: '{column}' is '{text}'", 0))
                self._texts[column] = first, count + 1
            yield row

    def of_row(self, row: Mapping[str, float]) -> list[Output]:
        """Return relative topics and messages of a row."""
        return self._rows.mapper.take(TABLE, row, 0)

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages of all rows.

        Raises:
            BagError: the times are in a unit that is not recognised, or a line cannot be read.
        """
        return self._rows.messages(self.rows(), self._text.units)

    def share(self) -> float:
        """Return the share of the table that has been read."""
        return self._text.share()

    @property
    def notes(self) -> list[str]:
        """How the times were taken, where the map does not say."""
        return self._rows.notes

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        texts = {f"{first}: no number": count for first, count in self._texts.values()}
        cut_off = (
            {"the last line has no end, and is left out: the log may be cut off": 0} if self._text.is_cut_off else {}
        )
        return {**self._rows.mapper.problems_at_end(), **texts, **cut_off}


class _MappedRows:
    """Messages of the rows of any table."""

    def __init__(self, path: Path, signal_map: SignalMap, columns: list[str]) -> None:
        """Find the columns of the map, and that of the time where the map does not name it."""
        self._path = path
        self._map = _with_times(signal_map, columns)
        self.notes: list[str] = []
        self.mapper = RecordMapper(self._map, Sources(columns=columns))
        self.needed = columns_of(self._map)

    def messages(self, rows: Iterable[Row], units: Mapping[str, str]) -> Iterator[Output]:
        """Yield topics and messages; `units` are those that the table states, by column."""
        for row in self._in_seconds(iter(rows), units):
            for topic, message in self.mapper.take(TABLE, row, 0):
                yield f"/{topic}", message

    def _in_seconds(self, rows: Iterator[Row], stated: Mapping[str, str]) -> Iterator[Row]:
        """Yield the rows with times in seconds, later where the first is before 1 s and the map has no offset."""
        first = list(islice(rows, _LOOKED_AT))
        signals = [signal for signal in self._map.signals if signal.origin.kind is Kind.TABLE]
        given = {signal.stamp: signal.stamp_unit for signal in signals}
        units = {column: unit or self._unit(column, first, stated) for column, unit in given.items()}
        times = [_seconds(first[0][column], unit) for column, unit in units.items()] if first else []
        offset = 0 if self._map.stamp_offset else max(map(start_offset, filter(isfinite, times)), default=0)
        for row in chain(first, rows):
            yield {**row, **{column: _seconds(row[column], unit) + offset for column, unit in units.items()}}

    def _unit(self, column: str, rows: list[Row], stated: Mapping[str, str]) -> str:
        """Return the unit of a column of times, of which the map states none.

        Raises:
            BagError: the steps between the times are those of no drive.
        """
        by_steps, step = unit_by_steps([row[column] for row in rows if isfinite(row[column])])
        named = stated.get(column) or unit_by_name(column)
        if not (named or by_steps) or not is_step(step, named or by_steps):
            said = f", and not in {named}" if named else ""
            raise BagError(f"{self._path}: the times in column '{column}' are {step:g} apart{said}: give 'stamp_unit'")
        unit = named or by_steps
        if unit != "s":
            self.notes.append(f"the times in column '{column}' are taken for {unit}: they are {step:g} apart")
        return unit


def _seconds(stamp: float, unit: str) -> float:
    return nanoseconds_of(stamp, unit) / NANOSECONDS if unit != "s" and isfinite(stamp) else stamp


def _with_times(signal_map: SignalMap, columns: Collection[str]) -> SignalMap:
    """Return the map with the column of the time in the signals that name none.

    Raises:
        ParameterError: there is no such column, or several.
    """
    if not any(each.origin.kind is Kind.TABLE and each.stamp == _NO_STAMP for each in signal_map.signals):
        return signal_map
    found = [column for column in columns if is_time(column)]
    if len(found) != 1:
        which = f"several columns may be that of the time, {', '.join(found)}" if found else "no column is the time"
        raise ParameterError(f"{signal_map.path}: {which}: give 'stamp: COLUMN', one of {', '.join(columns)}")
    signals = (
        replace(each, stamp=found[0]) if each.origin.kind is Kind.TABLE and each.stamp == _NO_STAMP else each
        for each in signal_map.signals
    )
    return replace(signal_map, signals=tuple(signals))


def is_time(column: str) -> bool:
    """Whether a column is one of times by its name, with or without a unit: `t`, `Time [s]`, `timestamp_us`."""
    name = column.strip().lower()
    unit = unit_by_name(name)
    bare = name.rstrip("])")[: -len(unit)].rstrip("[( _") if unit else name
    return name in TIME_COLUMNS or bare in TIME_COLUMNS


def columns_of(signal_map: SignalMap) -> tuple[str, ...]:
    """Return the columns of a table that a map names, each once, without that of a time that it does not name.

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
        stamp = () if signal.stamp == _NO_STAMP else (signal.stamp,)
        flag = () if signal.flag is None else (signal.flag.field,)
        found.update(dict.fromkeys((*stamp, *signal.fields, *flag)))
    return tuple(found)


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
        self._path = path
        self._file = _parquet(path)
        self._rows = _MappedRows(path, signal_map, self._file.schema_arrow.names)
        self._read = 0

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages of all rows; an empty cell is a value that there is not.

        Raises:
            BagError: a column does not hold numbers, or the file cannot be read to its end.
        """
        return self._rows.messages(self._batches(), {})

    @property
    def notes(self) -> list[str]:
        """How the times were taken, where the map does not say."""
        return self._rows.notes

    def share(self) -> float:
        """Return the share of the table that has been read."""
        return self._read / max(int(self._file.metadata.num_rows), 1)

    def problems(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._rows.mapper.problems_at_end()

    def _batches(self) -> Iterator[Row]:
        needed = self._rows.needed
        try:
            for batch in self._file.iter_batches(_ROWS, columns=list(needed)):
                columns = [_numbers(batch.column(name)) for name in needed]
                for name, column in zip(needed, columns, strict=True):
                    if column is None:
                        raise BagError(f"{self._path}: column '{name}' does not hold numbers")
                for values in zip(*(column for column in columns if column is not None), strict=True):
                    yield dict(zip(needed, values, strict=True))
                self._read += batch.num_rows
        except BagError:
            raise
        except Exception as error:  # pyarrow passes on whatever its readers raise
            raise BagError(f"{self._path} cannot be read to its end: {error}") from error


def parquet_head(path: Path, count: int) -> tuple[list[str], list[Row]]:
    """Return the columns of numbers of a table and its first rows, at most `count`.

    Raises:
        BagError, OSError, ParameterError: as ParquetTable.
    """
    file = _parquet(path)
    try:
        batch = next(iter(file.iter_batches(count)), None)
    except Exception as error:  # as above
        raise BagError(f"{path} cannot be read: {error}") from error
    columns = {} if batch is None else {name: _numbers(batch.column(name)) for name in batch.schema.names}
    known = {name: column for name, column in columns.items() if column is not None}
    return list(known), [dict(zip(known, values, strict=True)) for values in zip(*known.values(), strict=True)]


def _parquet(path: Path) -> Any:
    try:
        from pyarrow import parquet
    except ImportError as error:
        raise ParameterError(f"Parquet tables need one more package: {INSTALL_LINE}") from error
    path.stat()
    try:
        return parquet.ParquetFile(path)
    except Exception as error:  # as above
        raise BagError(f"{path} cannot be read: {error}") from error


def _numbers(column: Any) -> list[float] | None:
    """Return a column as numbers, seconds where it holds times; None where it holds something else."""
    values = column.to_numpy(zero_copy_only=False)
    if np.issubdtype(values.dtype, np.datetime64):
        return [float(each) for each in values.astype("datetime64[ns]").astype(np.int64) / 1e9]
    try:
        return [float(each) for each in values.astype(np.float64)]
    except (TypeError, ValueError):
        return None
