"""Parallel runs in processes, with a progress bar."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

Job = TypeVar("Job")
Result = TypeVar("Result")


def in_processes(work: Callable[[Job], Result], jobs: Sequence[Job], title: str, processes: int) -> list[Result]:
    """Do every job; the results in the order of the jobs.

    Args:
        work: a function of a module.
        jobs: its arguments.
        title: of the progress bar.
        processes: how many share the jobs; with 1 this process does them.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn()) as progress:
        bar = progress.add_task(title, total=len(jobs))
        if processes == 1:
            found = []
            for job in jobs:
                found.append(work(job))
                progress.advance(bar)
            return found
        results: dict[int, Result] = {}
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
            pending = {pool.submit(work, job): number for number, job in enumerate(jobs)}
            for done in as_completed(pending):
                results[pending[done]] = done.result()
                progress.advance(bar)
        return [results[number] for number in range(len(jobs))]
