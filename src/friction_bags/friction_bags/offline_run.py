"""One run of the estimators over a bag without middleware: messages of the bag in, a bag with their outputs out."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from fcntl import F_SETPIPE_SZ, fcntl
from multiprocessing import get_context
from operator import itemgetter
from pathlib import Path
from time import perf_counter

from friction_bags.bag_reader import BagReader
from friction_bags.bag_writer import BagWriter
from friction_bags.cdr import installed_topic
from friction_bags.graph_parts import independent_parts
from friction_bags.offline_part import (
    ProcessOptions,
    SayOnce,
    output_places,
    processors_for,
    received_outputs,
    send_outputs,
    taken_topics,
)
from friction_bags.part_run import Outputs, PartRun

_CHUNK_SIZE = 4 << 20
_PROGRESS_EVERY = 1000
_place = itemgetter(0)
_PIPE_SIZE = 1 << 20
"""[bytes] What a process may be ahead of the one that writes: with the usual 64 kB they wait for each other."""


@dataclass(frozen=True)
class ProcessResult:
    """What was done to a bag."""

    bag: str
    messages: int
    """Read."""
    outputs: int
    """Made by the estimators."""
    duration: float
    """[s] of the bag."""
    seconds: float
    """[s] it took."""
    problems: tuple[str, ...]


def process_bag(
    bag: Path, out: Path, options: ProcessOptions, processes: int, progress: Callable[[float], None]
) -> ProcessResult:
    """Run the estimators over a bag and write a bag of its topics and theirs.

    Topics of the bag that the estimators make are replaced. An output is recorded at the stamp of the message that
    caused it. The bytes of the result depend neither on the run nor on the number of processes.

    Args:
        bag: to be read.
        out: to be made.
        options: what to do.
        processes: among which the wheels are divided, at most.
        progress: is told the part that is done, 0 to 1.

    Raises:
        BagError: the bag cannot be read, names no wheels, or the other cannot be made.
        ParameterError: a parameter is bad.
    """
    begun = perf_counter()
    with ExitStack() as stack:
        reader = stack.enter_context(BagReader(bag))
        processors = processors_for(reader, options, SayOnce())
        taken = taken_topics(reader, processors, options.prefix)
        parts = independent_parts(processors, processes)
        made = {topic: kind for processor in processors for topic, kind in processor.outputs.items()}
        writer = stack.enter_context(BagWriter(out, chunk_size=_CHUNK_SIZE, custom_data=reader.custom_data))
        copied = {
            topic: writer.add_topic(topic)
            for topic in reader.counts
            if not options.outputs_only and topic.name.removeprefix(options.prefix) not in made
        }
        places = output_places(processors)
        channels = [writer.add_topic(installed_topic(options.prefix + name, made[name])) for name in places]
        here = PartRun(parts[0], places)
        elsewhere = [stack.enter_context(_process(bag, part, len(parts), options)) for part in range(1, len(parts))]
        total = max(reader.message_count, 1)
        count = given = 0
        for topic, stamp, data in reader.messages({**copied, **taken}):
            copy, name = copied.get(topic), taken.get(topic)
            if copy is not None:
                writer.write(copy, stamp, data)
            if name is not None:
                outputs = here.take(name, data)
                for other in elsewhere:
                    outputs += next(other)
                outputs.sort(key=_place)
                for place, encoded in outputs:
                    writer.write(channels[place], stamp, encoded)
                given += len(outputs)
            count += 1
            if count % _PROGRESS_EVERY == 0:
                progress(count / total)
        progress(1.0)
        duration = (reader.end - reader.start) * 1e-9
        refused = [f"{name}: {number} messages cannot be decoded" for name, number in here.refused.items()]
        problems = (*reader.problems, *refused)
        return ProcessResult(str(bag), count, given, duration, perf_counter() - begun, problems)


@contextmanager
def _process(bag: Path, part: int, parts: int, options: ProcessOptions) -> Iterator[Iterator[Outputs]]:
    """Outputs of a part that runs in a process of its own (spawned: a forked one would hang in the middleware)."""
    context = get_context("spawn")
    here, there = context.Pipe(duplex=False)
    fcntl(there.fileno(), F_SETPIPE_SZ, _PIPE_SIZE)
    process = context.Process(target=send_outputs, args=(bag, part, parts, options, there), daemon=True)
    process.start()
    there.close()
    try:
        yield received_outputs(here)
    finally:
        here.close()
        process.terminate()
        process.join()
