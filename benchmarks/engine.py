"""Jobs of the studies on the processes of this machine or on a Dask cluster, kept so that a study goes on where it was.

A job is a function of a module with one argument, both of which pickle. With `keep` its result is a file, under the
digest of function, argument, code and libraries: what another code has made is never read. A file appears whole.
"""

from __future__ import annotations

import argparse
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from friction_parameters.command_line import UserError, count
from friction_runtime.source_digest import source_digest

Job = TypeVar("Job")
Result = TypeVar("Result")

_ROOT = Path(__file__).parents[1]
_STUDIES = ("benchmarks", "book", "campaigns")
_LIBRARIES = ("numpy", "scipy")


@dataclass(frozen=True)
class Engine:
    """Where jobs run."""

    workers: int = 1
    """Processes of this machine; with 1 it is this process."""
    scheduler: str = ""
    """Address of the scheduler of a Dask cluster; empty: this machine."""
    keep: Path | None = None
    """Directory of the results."""


ENGINE: ContextVar[Engine] = ContextVar("ENGINE")
"""That of the study that runs; without one, this process."""


def add_engine_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=count, default=os.cpu_count() or 1, metavar="N", help="processes")
    where.add_argument("--scheduler", default="", metavar="ADDRESS", help="instead: that of a Dask cluster")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep each result here, and go on where a run ended")


def engine_of(options: argparse.Namespace) -> Engine:
    """Return what the command line chose."""
    return Engine(options.workers, options.scheduler, options.keep)


def results_of(work: Callable[[Job], Result], jobs: Sequence[Job], title: str) -> list[Result]:
    """Do every job, with a progress bar of this title; the results in the order of the jobs.

    Raises:
        OSError: there is no scheduler, or results cannot be kept.
        UserError: a worker of the cluster has other code.
    """
    engine = ENGINE.get(Engine())
    files = {} if engine.keep is None else {number: engine.keep / _name(work, job) for number, job in enumerate(jobs)}
    found: dict[int, Any] = {number: pickle.loads(file.read_bytes()) for number, file in files.items() if file.exists()}
    left = {number: job for number, job in enumerate(jobs) if number not in found}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn()) as progress:
        bar = progress.add_task(title, total=len(jobs), completed=len(found))
        for number, result in _as_made(engine, work, left) if left else ():
            found[number] = result
            if number in files:
                _keep(files[number], result)
            progress.advance(bar)
    return [found[number] for number in range(len(jobs))]


def _as_made(engine: Engine, work: Callable[[Job], Result], jobs: Mapping[int, Job]) -> Iterator[tuple[int, Result]]:
    if engine.scheduler:
        yield from _on_cluster(engine.scheduler, work, jobs)
    elif engine.workers == 1:
        yield from ((number, work(job)) for number, job in jobs.items())
    else:
        with ProcessPoolExecutor(engine.workers, mp_context=get_context("spawn")) as pool:
            pending = {pool.submit(work, job): number for number, job in jobs.items()}
            yield from ((pending[done], done.result()) for done in as_completed(pending))


def _on_cluster(address: str, work: Callable[[Job], Result], jobs: Mapping[int, Job]) -> Iterator[tuple[int, Result]]:
    from distributed import Client  # of `make fleet`; nothing else needs it
    from distributed import as_completed as as_made

    with Client(address) as client:
        if set(client.run(code_digest).values()) - {code_digest()}:
            raise UserError("a worker has other code than this process")
        pending = {client.submit(work, job, pure=False): number for number, job in jobs.items()}
        yield from ((pending[done], done.result()) for done in as_made(list(pending)))


def _name(work: Callable[[Job], Result], job: Job) -> str:
    of_job = f"{code_digest()} {work.__module__}.{work.__qualname__} ".encode() + pickle.dumps(job)
    return f"{sha256(of_job).hexdigest()[:32]}.pickle"


def _keep(file: Path, result: object) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    unfinished = file.with_suffix(f".{os.getpid()}")
    unfinished.write_bytes(pickle.dumps(result))
    unfinished.replace(file)


@cache
def code_digest() -> str:
    """Return the digest of the sources of all packages and studies, and of the libraries."""
    packages = sorted(path.name for path in (_ROOT / "src").iterdir() if find_spec(path.name) is not None)
    return source_digest((*_STUDIES, *packages), _LIBRARIES)
