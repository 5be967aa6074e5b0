"""Throughput of the engine with one and two workers, and of a plain pool of processes beside it."""

from __future__ import annotations

import resource
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from shutil import rmtree
from time import perf_counter

from friction_fleet.__main__ import main
from friction_fleet.dataset import Dataset
from friction_fleet.driver import open_tasks
from friction_fleet.settings import Settings
from friction_fleet.task import process

_WORKERS = (1, 2)


def measure_engine(pattern: str, out: Path, rounds: int) -> list[dict[str, str | float]]:
    """Process the bags with each engine and number of workers in turn; return the best of some rounds of each."""
    best: dict[tuple[str, int], dict[str, str | float]] = {}
    for _ in range(rounds):
        for engine, run in (("dask", _by_dask), ("pool", _by_pool)):
            for workers in _WORKERS:
                tables = out / "tables"
                rmtree(tables, ignore_errors=True)
                cpu, begun = _cpu(), perf_counter()
                run(pattern, str(tables), workers)
                seconds, used = perf_counter() - begun, _cpu() - cpu
                rows = Dataset(str(tables)).bags()
                row: dict[str, str | float] = {
                    "engine": engine,
                    "workers": float(workers),
                    "bags": float(len(rows)),
                    "seconds": seconds,
                    "bags a second": len(rows) / seconds,
                    "CPU seconds a bag": used / len(rows),
                    "largest worker [MB]": max(each["memory_mb"] or 0.0 for each in rows),
                }
                if (engine, workers) not in best or seconds < float(best[engine, workers]["seconds"]):
                    best[engine, workers] = row
    return list(best.values())


def _by_dask(pattern: str, tables: str, workers: int) -> None:
    main(["process", pattern, "--out", tables, "--workers", str(workers)])


def _by_pool(pattern: str, tables: str, workers: int) -> None:
    tasks = open_tasks(pattern, tables, Settings(), retry_errors=False).left
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        list(pool.map(process, tasks))


def _cpu() -> float:
    """Return the CPU time of this process and of those that it has ended [s]."""
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime
