"""One bag to the rows of the tables: what a worker does. Imports no engine."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from datetime import datetime, timezone
from hashlib import sha256
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, time_ns

import fsspec

from friction_adapter.map_file import load_map
from friction_bags.bag_io.bag_format import METADATA_NAME, read_custom_data
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.importers.import_log import import_log, is_bag
from friction_bags.offline.estimated_run import estimated_run
from friction_fleet.dataset import BAGS, BOUNDS, BRAKINGS, DAMAGED, DUPLICATE, ERROR, OK, SCHEMAS, Dataset
from friction_fleet.places import read_places
from friction_fleet.rows import Row, rows_of_bounds, rows_of_brakings
from friction_fleet.settings import Settings
from friction_runtime.reports import report_kind
from vehicle_models.vehicle_file import shipped_vehicles

VEHICLE_ID = "vehicle_id"
"""Key of the note of a bag that names the one car that it is of; else cars are told apart by their vehicle files."""
_BLOCK = 1 << 20
_MEGABYTE = 1024.0
"""In the unit of ru_maxrss."""
_MOST_PROBLEMS = 20


class OtherCodeError(Exception):
    """A worker has other code or files than the driver: its results would be of other settings."""


@dataclass(frozen=True)
class Task:
    """A bag to process."""

    path: str
    """URL of a bag or log."""
    file_stamp: str
    """Size and time of change, by which the driver knows it again."""
    out: str
    """URL of the dataset."""
    settings: Settings
    digest: str
    """Of the settings, by the driver."""


def process(task: Task) -> Row:
    """Process a bag and write its rows; the one of `bags` is written last and returned.

    A bag that cannot be processed is a row, too. Rows do not depend on the run: who comes twice writes the same.

    Raises:
        OtherCodeError: code or files of this worker are not those of the driver.
        OSError: the storage cannot be read or written.
    """
    if task.settings.digest() != task.digest:
        raise OtherCodeError("a worker has other code or files than the driver: install the same on all machines")
    begun, cpu = perf_counter(), process_time()
    dataset = Dataset(task.out)
    with TemporaryDirectory(prefix="friction_fleet_") as name:
        directory = Path(name)
        bag = _local(task.path, directory / "source")
        row = blank_row(task, *content_key(bag, task.digest))
        others = [each for each in dataset.committed(row["bag"]) if each["status"] != DUPLICATE]
        if others and others[0]["path"] != task.path:
            row["status"] = DUPLICATE
        else:
            _fill(task, row, bag, directory, dataset)
    row["seconds"], row["cpu_seconds"] = perf_counter() - begun, process_time() - cpu
    row["memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MEGABYTE
    row["committed"] = time_ns() // 1000
    dataset.commit(row)
    return row


def blank_row(task: Task, key: str, size: int) -> Row:
    """Return the row of a bag of which only key and size [bytes] are known."""
    known = {"bag": key, "bytes": size, "path": task.path, "file_stamp": task.file_stamp, "settings": task.digest}
    return dict.fromkeys(SCHEMAS[BAGS].names) | known


def content_key(bag: Path, digest: str) -> tuple[str, int]:
    """Return key and size [bytes] of a bag: names and order of recording do not count, notes and vehicle file do.

    Raises:
        OSError: it cannot be read.
    """
    found, size = sha256(digest.encode()), 0
    for file in sorted(bag.rglob("*")) if bag.is_dir() else [bag]:
        if file.is_file() and file.name != METADATA_NAME:
            content = sha256()
            for block in _blocks(file):
                content.update(block)
                size += len(block)
            found.update(content.digest())
    notes = read_custom_data(bag) if bag.is_dir() else {}
    found.update(repr(sorted(notes.items())).encode())
    vehicle = notes.get(VEHICLE_NOTE, "")
    if vehicle and vehicle not in shipped_vehicles() and Path(vehicle).is_file():
        found.update(Path(vehicle).read_bytes())
    return found.hexdigest()[:32], size


def _fill(task: Task, row: Row, bag: Path, directory: Path, dataset: Dataset) -> None:
    """Process a bag, complete its row, and write the others."""
    brakings: list[Row] = []
    bounds: list[Row] = []
    try:
        brakings, bounds = _rows(task.settings, row, bag, directory)
        row["status"] = DAMAGED if row["problems"] else OK
    except Exception as error:  # whatever is wrong with a bag, the others go on
        row["status"], row["error"] = ERROR, f"{type(error).__name__}: {error}".replace(str(directory), "")[:500]
    row["brakings"] = len({each["start"] for each in brakings})
    row["fits"] = len({each["start"] for each in brakings if each["mu_max"] is not None})
    if row["start"] is not None:
        date = datetime.fromtimestamp(row["start"] / 1e6, timezone.utc).date().isoformat()
        dataset.put_rows(BRAKINGS, row["bag"], row["vehicle"], date, brakings)
        dataset.put_rows(BOUNDS, row["bag"], row["vehicle"], date, bounds)


def _rows(settings: Settings, row: Row, bag: Path, directory: Path) -> tuple[list[Row], list[Row]]:
    """Run the estimators and return the rows of brakings and bounds."""
    printed = StringIO()
    map_file, source = settings.map_file, bag
    with redirect_stderr(printed), redirect_stdout(StringIO()):
        if map_file and not is_bag(bag):
            source, map_file = directory / "imported", ""
            import_log(bag, load_map(settings.map_file, settings.vehicle), None, source)
        result, run = estimated_run(source, settings.options(map_file))
        places = read_places(source)
    warnings = dict.fromkeys(report_kind(line) for line in printed.getvalue().splitlines() if line.strip())
    row["problems"] = list(dict.fromkeys((*result.problems, *run.problems)))[:_MOST_PROBLEMS]
    row["error"] = "; ".join(warnings)[:500] or None
    row["vehicle"] = run.notes.get(VEHICLE_ID) or Path(run.notes[VEHICLE_NOTE]).stem
    row["start"], row["duration"], row["messages"] = run.start // 1000, result.duration, result.messages
    key, vehicle = row["bag"], row["vehicle"]
    return rows_of_brakings(run, places, key, vehicle), rows_of_bounds(run, places, key, vehicle)


def _local(url: str, target: Path) -> Path:
    """Return a local path of a bag, copied below `target` if it is no local file."""
    fs, path = fsspec.core.url_to_fs(url)
    if "file" in fs.protocol:
        return Path(path)
    target.mkdir()
    copy = target / path.rstrip("/").rpartition("/")[2]
    fs.get(path, str(copy), recursive=True)
    return copy


def _blocks(file: Path) -> Iterator[bytes]:
    with file.open("rb") as opened:
        while block := opened.read(_BLOCK):
            yield block
