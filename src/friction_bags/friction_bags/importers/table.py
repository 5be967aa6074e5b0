"""Tables: CSV files whose first line names the columns."""

import csv
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TextIO

from friction_adapter.record_mapper import RecordMapper
from friction_adapter.signal_map import ARRIVAL, Kind, SignalMap
from friction_adapter.sources import TABLE, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output

_DELIMITERS = ",;\t"


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
        with path.open(newline="", encoding="utf-8-sig") as stream:
            head = stream.readline()
        if not head.strip():
            raise BagError(f"{path} is empty: its first line must name the columns")
        self._delimiter = max(_DELIMITERS, key=head.count)
        self._columns = next(csv.reader([head.lstrip("# ")], delimiter=self._delimiter))
        self._needed = columns_of(signal_map)
        self._size = max(path.stat().st_size, 1)
        self._stream: TextIO | None = None
        self._mapper = RecordMapper(signal_map, Sources(columns=self._columns))

    def rows(self) -> Iterator[dict[str, float]]:
        """Yield the rows as numbers by column, those of the map only.

        Raises:
            BagError: a value is not a number; the text names the line.
        """
        with self._path.open(newline="", encoding="utf-8-sig") as stream:
            self._stream = stream
            stream.readline()
            reader = csv.DictReader(stream, self._columns, delimiter=self._delimiter)
            for row in reader:
                try:
                    yield {column: float(row[column]) for column in self._needed}
                except (TypeError, ValueError):
                    raise BagError(f"{self._path}, line {reader.line_num + 1}: a value is not a number") from None

    def of_row(self, row: Mapping[str, float]) -> list[Output]:
        """Return relative topics and messages of a row."""
        return self._mapper.take(TABLE, row, 0)

    def messages(self) -> Iterator[Output]:
        """Yield topics and messages of all rows.

        Raises:
            BagError: a value is not a number; the text names the line.
        """
        for row in self.rows():
            for topic, message in self.of_row(row):
                yield f"/{topic}", message

    def share(self) -> float:
        """Return the share of the table that has been read."""
        stream = self._stream
        return 0.0 if stream is None or stream.closed else stream.buffer.tell() / self._size

    def troubles(self) -> dict[str, int]:
        """Return how often something could not be used, by what it is."""
        return self._mapper.troubles()


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
