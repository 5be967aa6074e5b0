"""Tables in Parquet files, through pyarrow."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from friction_adapter.ros.record_mapper import RecordMapper
from friction_adapter.signal_map import SignalMap
from friction_adapter.sources import TABLE, Sources
from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.table import columns_of, put_later
from friction_parameters.command_line import install_line
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Output

SUFFIX = ".parquet"
INSTALL_LINE = install_line("pyarrow")
_ROWS = 10_000
"""Rows that are read at once."""


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
        return self._mapper.problems()

    def _numbers(self, name: str, column: Any) -> list[float]:
        values = column.to_numpy(zero_copy_only=False)
        if np.issubdtype(values.dtype, np.datetime64):
            return [float(each) for each in values.astype("datetime64[ns]").astype(np.int64) / 1e9]
        try:
            return [float(each) for each in values.astype(np.float64)]
        except (TypeError, ValueError):
            raise BagError(f"{self._path}: column '{name}' does not hold numbers") from None
