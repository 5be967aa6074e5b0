"""Progress of a command on a terminal."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn


@contextmanager
def bars(names: Sequence[str]) -> Iterator[Callable[[int, float], None]]:
    """Yield a function that shows progress on a terminal, by the index of the name and the share that is done."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        tasks = [progress.add_task(name, total=1.0) for name in names]
        yield lambda index, part: progress.update(tasks[index], completed=part)
