"""A bag through the processors, in a chain of processes."""

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from fcntl import F_SETPIPE_SZ, fcntl
from multiprocessing import get_context
from multiprocessing.connection import Connection
from operator import itemgetter
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from time import perf_counter
from typing import Any

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode, encode, installed_topic
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.offline.plan import (
    OfflinePlan,
    ProcessOptions,
    SayOnce,
    Stage,
    graph_stages,
    open_bag,
    output_numbers,
    plan_for,
)
from friction_runtime.processor import Output, ProcessorGraph
from vehicle_models.nanoseconds import NANOSECOND

Outputs = list[tuple[int, bytes]]
"""Topic number and CDR of each output for one message."""
_BATCH = 128
"""Steps that are sent together."""
_PIPE_SIZE = 1 << 20
"""How far a stage may be ahead of the next [bytes]: with the usual 64 kB they wait for each other."""

Step = tuple[int, int, bytes, Outputs]
"""Number of a topic of the bag, recording stamp [ns], CDR, outputs so far."""
_CHUNK_SIZE = 4 << 20
_PROGRESS_EVERY = 1000
_number = itemgetter(0)


def fed(graph: ProcessorGraph, name: str, data: bytes, refused: dict[str, int]) -> Iterable[Output]:
    """Feed processors with a message as CDR and return their outputs.

    One that cannot be decoded is skipped, and counted by topic in `refused`; one that nobody takes has no outputs.
    """
    kind = graph.inputs.get(name)
    if kind is None:
        return ()
    try:
        message: Any = decode(data, kind)
    except ValueError:
        refused[name] = refused.get(name, 0) + 1
        return ()
    return graph.feed(name, message)


class StageRun:
    """Takes the messages of a bag with the outputs of the stages before, adds its own; `refused` as in `fed`."""

    def __init__(self, stage: Stage, numbers: Mapping[str, int]) -> None:
        """Start without messages.

        Args:
            stage: processors of the stage.
            numbers: numbers of the topics that the processors of all stages make.
        """
        self._graph = ProcessorGraph(stage)
        self._numbers = dict(numbers)
        self._names = list(numbers)
        self.refused: dict[str, int] = {}

    def take(self, name: str, data: bytes, outputs: Outputs) -> None:
        """Take a message with its relative topic and its outputs so far; append those of this stage."""
        made = [(self._names[number], encoded) for number, encoded in outputs]
        self._feed(name, data, outputs)
        for topic, encoded in made:
            self._feed(topic, encoded, outputs)

    def _feed(self, name: str, data: bytes, outputs: Outputs) -> None:
        for topic, made in fed(self._graph, name, data, self.refused):
            outputs.append((self._numbers[topic], encode(made)))


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


def not_decoded(refused: Mapping[str, int]) -> list[str]:
    """Return texts on messages that could not be decoded, counted by topic."""
    return [f"{name}: {number} messages cannot be decoded" for name, number in refused.items()]


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
        behind.send((*problems, *not_decoded(run.refused)))
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


@dataclass(frozen=True)
class ProcessResult:
    """Result of processing a bag."""

    bag: str
    messages: int
    """Messages read."""
    outputs: int
    """Messages made by the estimators."""
    duration: float
    """Duration of the bag [s]."""
    seconds: float
    """Processing time [s]."""
    problems: tuple[str, ...]


def process_bag(
    bag: Path, out: Path, options: ProcessOptions, processes: int, progress: Callable[[float], None]
) -> ProcessResult:
    """Run the estimators over a bag and write a bag of its topics and theirs.

    Topics of the bag that the estimators make are replaced. An output is recorded at the stamp of the message that
    caused it. The bytes of the result depend neither on the run nor on the number of processes.

    Args:
        bag: bag to read.
        out: bag to write.
        options: options of the user.
        processes: largest number of processes for the estimators.
        progress: called with the share that is done, 0 to 1.

    Raises:
        BagError: the bag cannot be read, holds no wheel of the car, or the new one cannot be made.
        ParameterError: a parameter or the vehicle file is bad, or no car is named.
    """
    begun = perf_counter()
    with ExitStack() as stack:
        say = SayOnce()
        reader = stack.enter_context(open_bag(bag, options.map_file, options.vehicle, options.prefix, say))
        plan, processors = plan_for(reader, options, say)
        stages = graph_stages(processors, processes)
        made = {topic: kind for processor in processors for topic, kind in processor.outputs.items()}
        notes = {**reader.custom_data, VEHICLE_NOTE: plan.vehicle_note}
        writer = stack.enter_context(BagWriter(out, chunk_size=_CHUNK_SIZE, custom_data=notes))
        copies = [
            writer.add_topic(topic) if copied else None
            for topic, copied in zip(reader.counts, plan.copied, strict=True)
        ]
        numbers = output_numbers(processors)
        channels = [writer.add_topic(installed_topic(options.prefix + name, made[name])) for name in numbers]
        run = StageRun(stages[-1], numbers)
        problems: list[str] = []
        if len(stages) == 1:
            steps = read_steps(reader, plan)
        else:
            steps = stack.enter_context(steps_of_stages(plan, len(stages), problems))
        gc.freeze()  # what has been loaded stays: no need to look for garbage in it
        total = max(reader.message_count, 1)
        count = given = 0
        for topic, stamp, data, outputs in steps:
            copy, name = copies[topic], plan.taken[topic]
            if copy is not None:
                writer.write(copy, stamp, data)
            if name:
                run.take(name, data, outputs)
                outputs.sort(key=_number)
                for number, encoded in outputs:
                    writer.write(channels[number], stamp, encoded)
                given += len(outputs)
            count += 1
            if count % _PROGRESS_EVERY == 0:
                progress(min(count / total, 1.0))  # what a map makes is not counted before
        progress(1.0)
        duration = (reader.end - reader.start) * NANOSECOND
        found = tuple(dict.fromkeys([*reader.problems, *problems, *not_decoded(run.refused)]))
        return ProcessResult(str(bag), count, given, duration, perf_counter() - begun, found)
