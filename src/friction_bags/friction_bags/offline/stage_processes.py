"""Stages of the estimators, each in its own process: a chain from the one that reads to the one that writes."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from fcntl import F_SETPIPE_SZ, fcntl
from multiprocessing import get_context
from multiprocessing.connection import Connection
from signal import SIG_IGN, SIGINT, signal

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.offline.graph_stages import graph_stages
from friction_bags.offline.plan import OfflinePlan, SayOnce, output_numbers
from friction_bags.offline.stage_run import Outputs, StageRun

_BATCH = 128
"""Steps that are sent together."""
_PIPE_SIZE = 1 << 20
"""How far a stage may be ahead of the next [bytes]: with the usual 64 kB they wait for each other."""

Step = tuple[int, int, bytes, Outputs]
"""Number of a topic of the bag, recording stamp [ns], CDR, outputs so far."""


def read_steps(reader: BagReader, plan: OfflinePlan) -> Iterator[Step]:
    """Yield the messages of a bag that the plan needs."""
    numbers = {topic: number for number, topic in enumerate(reader.counts) if plan.taken[number] or plan.copied[number]}
    for topic, stamp, data in reader.messages(numbers):
        yield numbers[topic], stamp, data, []


@contextmanager
def steps_of_stages(plan: OfflinePlan, stages: int, problems: list[str]) -> Iterator[Iterator[Step]]:
    """Yield the steps after all stages but the last, each of which runs in a process of its own.

    Args:
        plan: plan for the bag.
        stages: number of all stages, at least two.
        problems: problems of the bag are appended when all steps are there.
    """
    context = get_context("spawn")  # a forked process would hang in the middleware
    processes = []
    before: Connection | None = None
    for stage in range(stages - 1):
        here, there = context.Pipe(duplex=False)
        with suppress(PermissionError):  # the system may allow less
            fcntl(there.fileno(), F_SETPIPE_SZ, _PIPE_SIZE)
        processes.append(context.Process(target=_run_stage, args=(plan, stage, stages, before, there), daemon=True))
        processes[-1].start()
        there.close()
        if before is not None:
            before.close()
        before = here
    assert before is not None
    try:
        yield _received(before, problems)
    finally:
        before.close()
        for process in processes:
            process.terminate()
            process.join()


def undecoded(run: StageRun) -> list[str]:
    """Return texts on messages of a stage that could not be decoded."""
    return [f"{name}: {number} messages cannot be decoded" for name, number in run.refused.items()]


def _run_stage(plan: OfflinePlan, stage: int, stages: int, before: Connection | None, behind: Connection) -> None:
    """Read the bag or take steps from the stage before; send them with the outputs, then a tuple of problems.

    An exception is sent instead of being raised.
    """
    signal(SIGINT, SIG_IGN)  # the writing process ends this one
    try:
        say = SayOnce()
        processors = plan.processors(say)
        run = StageRun(graph_stages(processors, stages)[stage], output_numbers(processors))
        problems: list[str] = []
        if before is not None:
            _send(_received(before, problems), run, plan, behind)
        else:
            with plan.open_bag(say) as reader:
                _send(read_steps(reader, plan), run, plan, behind)
                problems = reader.problems
        behind.send((*problems, *undecoded(run)))
    except BrokenPipeError:
        pass
    except Exception as error:
        behind.send(error)


def _send(steps: Iterator[Step], run: StageRun, plan: OfflinePlan, behind: Connection) -> None:
    batch: list[Step] = []
    for step in steps:
        number, _, data, outputs = step
        run.take(plan.taken[number], data, outputs)
        batch.append(step)
        if len(batch) == _BATCH:
            behind.send(batch)
            batch = []
    behind.send(batch)


def _received(before: Connection, problems: list[str]) -> Iterator[Step]:
    """Yield the steps that a stage sends.

    Raises:
        BagError: its process ended early, or sent an exception.
    """
    while True:
        try:
            batch = before.recv()
        except EOFError:
            raise BagError("a process of the estimators ended early (out of memory?)") from None
        if isinstance(batch, Exception):
            raise BagError(f"a process of the estimators failed: {batch}") from batch
        if isinstance(batch, tuple):
            problems.extend(batch)
            return
        yield from batch
