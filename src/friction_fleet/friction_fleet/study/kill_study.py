"""Tables of a fleet whose workers and drivers are killed, beside those of one quiet worker."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path
from random import Random
from time import perf_counter
from typing import Any

from friction_fleet.dataset import BOUNDS, BRAKINGS, FAILED, RUN_COLUMNS, Dataset

_DRIVER_KILLS = 2


def measure_kills(pattern: str, out: Path, every: float, seed: int) -> list[dict[str, str | float]]:
    """Process the bags twice; return a row of each run, and of what `--retry-errors` makes of the second.

    One quiet worker is the first; in the second a worker of two is killed at random every so many seconds, and the
    driver with all of them twice.

    Args:
        pattern: of the bags.
        out: directory of the tables.
        every: time between two kills [s].
        seed: of the choice of the worker.
    """
    quiet, killed = out / "quiet", out / "killed"
    begun = perf_counter()
    _process(pattern, quiet, "--workers", "1").wait()
    found = [_row("quiet", quiet, quiet, perf_counter() - begun, 0, 0)]
    rng, begun = Random(seed), perf_counter()
    workers, drivers, left = 0, 0, 0.5 * len(Dataset(str(quiet)).bags())
    child = _process(pattern, killed)
    while child.poll() is None:
        try:
            child.wait(every)
        except subprocess.TimeoutExpired:
            if drivers < _DRIVER_KILLS and len(Dataset(str(killed)).bags()) > drivers * left:
                kill_with_all_below(child)
                drivers += 1
                child = _process(pattern, killed)
            elif below := [each for each in processes_below(child.pid) if _is_worker(each)]:
                kill(rng.choice(below))
                workers += 1
    found.append(_row("killed", killed, quiet, perf_counter() - begun, workers, drivers))
    begun = perf_counter()
    _process(pattern, killed, "--retry-errors").wait()
    found.append(_row("the same, --retry-errors", killed, quiet, perf_counter() - begun, 0, 0))
    return found


def kill_with_all_below(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and those that it has started, as when a machine dies."""
    below = list(processes_below(process.pid))
    process.kill()
    for pid in below:
        kill(pid)
    process.wait()


def kill(pid: int) -> None:
    """Kill a process, if it has not ended by itself."""
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def processes_below(pid: int) -> Iterator[int]:
    """Yield the processes that a process has started, and those of these."""
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if int(fields[1]) == pid:
            child = int(status.parent.name)
            yield child
            yield from processes_below(child)


def _is_worker(pid: int) -> bool:
    try:
        return b"--multiprocessing-fork" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False


def _process(pattern: str, tables: Path, *options: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "friction_fleet", "process", pattern, "--out", str(tables), *options]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _row(
    name: str, tables: Path, quiet: Path, seconds: float, worker_kills: int, driver_kills: int
) -> dict[str, str | float]:
    rows = Dataset(str(tables)).bags()
    counts = Counter(str(row["status"]) for row in rows)
    return {
        "run": name,
        "bags": float(len(rows)),
        "status": ", ".join(f"{number} {status}" for status, number in sorted(counts.items())),
        "seconds": seconds,
        "workers killed": float(worker_kills),
        "drivers killed": float(driver_kills),
        "tables equal those of the quiet run": str(content(tables, RUN_COLUMNS) == content(quiet, RUN_COLUMNS)),
        "smallest worker [MB]": min(
            (row["memory_mb"] or 0.0 for row in rows if row["status"] not in FAILED), default=0.0
        ),
        "largest worker [MB]": max(row["memory_mb"] or 0.0 for row in rows),
    }


def content(tables: Path, without: Collection[str]) -> dict[str, Any]:
    """Return all rows, those of the bags without some columns."""
    dataset = Dataset(str(tables))
    rows = [{name: row[name] for name in row if name not in without} for row in dataset.bags()]
    return {"bags": rows, **{name: dataset.table(name).to_pylist() for name in (BRAKINGS, BOUNDS)}}
