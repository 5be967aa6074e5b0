"""`process`: bags to tables on Dask, a task a bag, with a bounded number of them on the way."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from itertools import islice
from pathlib import Path
from time import monotonic, perf_counter, time_ns
from typing import Any

import dask
import fsspec
from distributed import Client, Future, KilledWorker, LocalCluster, wait
from distributed import TimeoutError as NotYet

from friction_adapter.map_file import add_map_argument
from friction_bags.bag_vehicle import CAR_OTHERWISE
from friction_bags.progress_bars import bars
from friction_fleet.dataset import DUPLICATE, FAILED, KILLED, OK, Dataset
from friction_fleet.settings import Settings
from friction_fleet.task import OtherCodeError, Task, blank_row, process
from friction_parameters.command_line import UserError, count, positive
from vehicle_models.vehicle_file import add_vehicle_argument

_DEATHS = 3
"""Workers that a bag may take with it until its row is `killed`."""
_RETRIES = 2
"""Of a task whose storage fails."""
_AHEAD = 3
"""Tasks on the way for each worker."""
_LOOK, _ALONE = 10.0, 600.0
"""Time after which workers are counted again, and without any of which the run ends [s]."""
_UNREADABLE = "unreadable"


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "bags", metavar="GLOB", help="bags or logs, on any file system of fsspec: '/data/*', 's3://bucket/*'"
    )
    parser.add_argument("--out", required=True, metavar="URL", help="directory of the tables, made or continued")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=count, default=2, metavar="N", help="processes on this machine")
    where.add_argument("--scheduler", metavar="ADDRESS", help="scheduler of a Dask cluster, such as tcp://host:8786")
    parser.add_argument("--memory", type=positive, default=2.0, metavar="GB", help="a local worker with more is killed")
    parser.add_argument("--retry-errors", action="store_true", help="process bags again that failed or killed workers")
    add_vehicle_argument(parser, CAR_OTHERWISE)
    parser.add_argument("--params-file", type=Path, action="append", default=[], help="ROS parameter file; repeatable")
    parser.add_argument("--namespace", default="/", help="namespace of the topics, such as /car")
    add_map_argument(parser)


def run(options: Namespace) -> int:
    """Process the bags that are not done.

    Returns:
        Exit code: 0, 1 where a bag is damaged, failed, or could not be read from its storage.

    Raises:
        OSError: the dataset cannot be written, or there is no scheduler.
        ParameterError: map or vehicle file are bad.
        UserError: there is no bag, or a worker has other code.
    """
    files = tuple(file.resolve() for file in options.params_file)
    settings = Settings(options.vehicle, files, options.map, options.namespace)
    tasks = open_tasks(options.bags, options.out, settings, options.retry_errors)
    print(f"{len(tasks.left)} bags to process, {tasks.done} done before", flush=True)
    if not tasks.left:
        return 0
    begun = perf_counter()
    with _client(options) as client, bars([f"{len(tasks.left)} bags"]) as show:
        print(f"dashboard  {client.dashboard_link}", flush=True)
        counts: Counter[str] = Counter()
        for number, row in enumerate(rows_as_made(client, tasks.left)):
            counts[row["status"]] += 1
            if row["error"] and row["status"] in (*FAILED, _UNREADABLE):
                print(f"{row['status']}: {row['path']}: {row['error']}", file=sys.stderr)
            show(0, (number + 1) / len(tasks.left))
    seconds = perf_counter() - begun
    kinds = ", ".join(f"{number} {status}" for status, number in sorted(counts.items()))
    print(f"{kinds}; {seconds:.1f} s, {len(tasks.left) / seconds:.2f} bags a second")
    return int(bool(set(counts) - {OK, DUPLICATE}))


@dataclass(frozen=True)
class Tasks:
    """Bags to process, and the number of those that are done."""

    left: Sequence[Task]
    done: int


def open_tasks(pattern: str, out: str, settings: Settings, retry_errors: bool) -> Tasks:
    """Compare the bags that match a pattern with the dataset, by path, size and time of change: none is opened.

    Raises:
        ParameterError: map or vehicle file are bad.
        UserError: nothing matches.
    """
    fs, matched = fsspec.core.url_to_fs(pattern)
    paths = sorted(path for path in fs.glob(matched) if not path.rpartition("/")[2].startswith("."))
    if not paths:
        raise UserError(f"no bag matches {pattern}")
    digest = settings.digest()
    done = {
        (row["path"], row["file_stamp"])
        for row in Dataset(out).bags()
        if row["settings"] == digest and not (retry_errors and row["status"] in FAILED)
    }
    found = [Task(fs.unstrip_protocol(path), _file_stamp(fs, path), out, settings, digest) for path in paths]
    left = [task for task in found if (task.path, task.file_stamp) not in done]
    return Tasks(left, len(found) - len(left))


def rows_as_made(client: Client, tasks: Sequence[Task]) -> Iterator[Mapping[str, Any]]:
    """Yield the row of each bag as it comes; memory does not grow with their number.

    Raises:
        UserError: a worker has other code than this process, or there has been none for a while.
    """
    waiting = iter(tasks)
    running: dict[Future, Task] = {}
    seen = monotonic()
    while True:
        workers = len(client.nthreads())
        for task in islice(waiting, max(_AHEAD * max(workers, 1) - len(running), 0)):
            future = client.submit(process, task, key=f"bag-{task.path}-{time_ns()}", retries=_RETRIES, pure=False)
            running[future] = task
        if not running:
            return
        try:
            done = wait(list(running), timeout=_LOOK, return_when="FIRST_COMPLETED").done
        except NotYet:
            done = set()
        if workers:
            seen = monotonic()
        elif monotonic() - seen > _ALONE:
            raise UserError(f"no worker for {_ALONE:.0f} s; what is done is kept: `process` again continues")
        for future in done:
            yield _row(future, running.pop(future))


def _row(future: Future, task: Task) -> Mapping[str, Any]:
    """Return the row of a bag whose task has ended.

    Raises:
        UserError: a worker has other code than this process.
    """
    try:
        return future.result()
    except KilledWorker:
        return _killed(task)
    except OtherCodeError as error:
        raise UserError(str(error)) from error
    except Exception as error:  # of the storage: no row, the next run tries again
        return blank_row(task, "", 0) | {"status": _UNREADABLE, "error": f"{type(error).__name__}: {error}"}


def _killed(task: Task) -> Mapping[str, Any]:
    """Commit a bag whose workers died; its content is not read again, for that may be what kills."""
    row = blank_row(task, f"killed-{sha256(repr(task).encode()).hexdigest()[:25]}", 0)
    row |= {"status": KILLED, "error": f"{_DEATHS} workers died (out of memory?)", "committed": time_ns() // 1000}
    Dataset(task.out).commit(row)
    return row


@contextmanager
def _client(options: Namespace) -> Iterator[Client]:
    if options.scheduler:
        with Client(options.scheduler) as client:
            yield client
        return
    # a worker dies with its bag, not with what it has kept: nothing is spilled or paused
    limits = {f"distributed.worker.memory.{name}": False for name in ("target", "spill", "pause")}
    # on a machine that is busy with other things a worker takes minutes to come back, and would be given up
    patience = {"distributed.deploy.lost-worker-timeout": _ALONE, "distributed.comm.timeouts.connect": _ALONE}
    allowed = {"distributed.scheduler.allowed-failures": _DEATHS - 1}
    # it looks at the stack of a worker 100 times a second: 7 % of the time of a bag
    quick = {"distributed.worker.profile.enabled": False}
    with (
        dask.config.set({**limits, **patience, **allowed, **quick}),
        LocalCluster(
            n_workers=options.workers,
            threads_per_worker=1,
            memory_limit=f"{options.memory} GB",
            dashboard_address=":0",
            silence_logs=50,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def _file_stamp(fs: Any, path: str) -> str:
    """Return size and time of change of a bag, by its listing."""
    files = fs.find(path, detail=True) if fs.isdir(path) else {path: fs.info(path)}
    size = sum(each["size"] for each in files.values())
    changed = max((str(each.get("mtime") or each.get("LastModified") or "") for each in files.values()), default="")
    return f"{size} {changed}"
