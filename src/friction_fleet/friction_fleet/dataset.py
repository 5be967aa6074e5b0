"""Tables of a fleet as Parquet files on any file system of fsspec; what is written appears whole, or not at all."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any
from uuid import uuid4

import fsspec
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq

Row = Mapping[str, Any]
_STAMP = pa.timestamp("us", "UTC")
BAGS, BRAKINGS, BOUNDS = "bags", "brakings", "bounds"
TEXT, REAL, WHOLE = pa.string(), pa.float64(), pa.int64()
SCHEMAS: Mapping[str, pa.Schema] = {
    BAGS: pa.schema(
        [
            *(("bag", TEXT), ("path", TEXT), ("file_stamp", TEXT), ("bytes", WHOLE), ("status", TEXT), ("error", TEXT)),
            *(("vehicle", TEXT), ("start", _STAMP), ("duration", REAL), ("messages", WHOLE), ("brakings", WHOLE)),
            *(("fits", WHOLE), ("problems", pa.list_(TEXT)), ("settings", TEXT), ("committed", _STAMP)),
            *(("seconds", REAL), ("cpu_seconds", REAL), ("memory_mb", REAL)),
        ]
    ),
    BRAKINGS: pa.schema(
        [
            *(("bag", TEXT), ("vehicle", TEXT), ("of", TEXT), ("start", _STAMP), ("duration", REAL)),
            *(("stamp", _STAMP), ("latitude", REAL), ("longitude", REAL), ("cell", pa.uint64())),
            *(("from_speed", REAL), ("to_speed", REAL), ("deceleration", REAL), ("largest_slip", REAL)),
            *(("mu_used", REAL), ("mu_used_stddev", REAL), ("lambda_max", REAL), ("lambda_max_stddev", REAL)),
            *(
                ("mu_max", REAL),
                ("mu_max_stddev", REAL),
                ("valid", REAL),
                ("reason", TEXT),
                ("contradicted", pa.bool_()),
            ),
        ]
    ),
    BOUNDS: pa.schema(
        [
            *(("bag", TEXT), ("vehicle", TEXT), ("stamp", _STAMP), ("cell", pa.uint64())),
            *(("mu_used", REAL), ("mu_used_stddev", REAL), ("mu_proven", REAL), ("mu_lower", REAL)),
        ]
    ),
}
"""Columns of the tables; README.md describes them."""
RUN_COLUMNS = ("committed", "seconds", "cpu_seconds", "memory_mb")
"""Columns of `bags` that are of the run and not of the bag: they differ from run to run."""
OK, DAMAGED, ERROR, DUPLICATE, KILLED = "ok", "damaged", "error", "duplicate", "killed"
FAILED = (ERROR, KILLED)


class Dataset:
    """A directory of tables: bags/KEY/PATH.parquet, brakings and bounds/vehicle=V/date=D/KEY.parquet."""

    def __init__(self, url: str) -> None:
        """Name the directory; fsspec takes endpoints from its environment, such as FSSPEC_S3_ENDPOINT_URL."""
        self.url = url
        self._fs, self._root = fsspec.core.url_to_fs(url)

    def put(self, name: str, table: pa.Table) -> None:
        """Write a file, whole or not at all, also when the machine dies."""
        buffer = io.BytesIO()
        pq.write_table(table, buffer, compression="zstd")
        self.put_bytes(name, buffer.getvalue())

    def put_bytes(self, name: str, data: bytes) -> None:
        """Write a file of bytes; an object store does so in one request, elsewhere it is renamed."""
        target = f"{self._root}/{name}"
        if "file" not in self._fs.protocol:
            self._fs.pipe_file(target, data)
            return
        os.makedirs(os.path.dirname(target), exist_ok=True)
        part = f"{target}.{uuid4().hex}.part"
        with open(part, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, target)

    def put_rows(self, table: str, key: str, vehicle: str, date: str, rows: Sequence[Row]) -> None:
        """Write the rows of a bag to `brakings` or `bounds`."""
        if rows:
            name = f"{table}/vehicle={vehicle}/date={date}/{key}.parquet"
            self.put(name, pa.Table.from_pylist(list(rows), SCHEMAS[table]))

    def commit(self, row: Row) -> None:
        """Write the row of a bag, which makes its other rows valid."""
        name = f"{BAGS}/{row['bag']}/{_short(row['path'])}.parquet"
        self.put(name, pa.Table.from_pylist([row], SCHEMAS[BAGS]))

    def committed(self, key: str) -> list[dict[str, Any]]:
        """Return the rows of the bags with this key, of any path."""
        directory = f"{self._root}/{BAGS}/{key}"
        self._fs.invalidate_cache(directory)
        if not self._fs.exists(directory):
            return []
        return [row for name in self._files(f"{BAGS}/{key}") for row in self._read([name], BAGS).to_pylist()]

    def bags(self) -> list[dict[str, Any]]:
        """Return the newest row of each path, in the order of the paths.

        Of several paths with one content the first has the results, the others are duplicates of it.
        """
        newest: dict[str, dict[str, Any]] = {}
        results: dict[str, dict[str, Any]] = {}  # by content, also where its first path has another by now
        for row in self._read(self._files(BAGS), BAGS).to_pylist():
            for known, name in ((newest, "path"), (results, "bag")):
                before = known.get(row[name])
                is_newer = before is None or (before["committed"], before["bag"]) < (row["committed"], row["bag"])
                if is_newer and (known is newest or row["status"] != DUPLICATE):
                    known[row[name]] = row
        rows, seen = [], set()
        for path, row in sorted(newest.items()):
            of_path = {name: row[name] for name in ("path", "file_stamp")}
            first = row["bag"] not in seen and row["bag"] in results
            rows.append({**(results[row["bag"]] if first else _duplicate(row)), **of_path, "path": path})
            seen.add(row["bag"])
        return rows

    def table(self, name: str) -> pa.Table:
        """Return the rows of `brakings` or `bounds` of the bags as they are now, in a fixed order."""
        keys = {row["bag"] for row in self.bags() if row["status"] in (OK, DAMAGED)}
        files = [file for file in self._files(name) if file.rpartition("/")[2].removesuffix(".parquet") in keys]
        return self._read(files, name)

    def compact(self) -> int:
        """Delete the files of bags that were changed, processed again or removed by hand; return their number."""
        keys = {row["bag"] for row in self.bags()}
        old = [file for file in self._files(BAGS) if file.split("/")[-2] not in keys]
        for table in (BRAKINGS, BOUNDS):
            old += [file for file in self._files(table) if file.rpartition("/")[2].removesuffix(".parquet") not in keys]
        for file in old:
            self._fs.rm_file(file)
        return len(old)

    def _files(self, table: str) -> list[str]:
        directory = f"{self._root}/{table}"
        self._fs.invalidate_cache()
        found = self._fs.find(directory) if self._fs.exists(directory) else []
        return sorted((name for name in found if name.endswith(".parquet")), key=lambda name: name.rpartition("/")[2])

    def _read(self, files: Sequence[str], table: str) -> pa.Table:
        if not files:
            return SCHEMAS[table].empty_table()
        read = pyarrow.dataset.dataset(list(files), SCHEMAS[table], filesystem=self._fs, format="parquet")
        return read.to_table()


def _duplicate(row: Row) -> dict[str, Any]:
    kept = ("bag", "path", "file_stamp", "bytes", "settings", "committed")
    return {name: row[name] if name in kept else None for name in SCHEMAS[BAGS].names} | {"status": DUPLICATE}


def _short(path: str) -> str:
    return sha256(path.encode()).hexdigest()[:16]
