"""One run of the estimators over a bag without middleware: messages of the bag in, a bag with their outputs out."""

import gc
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from time import perf_counter

from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import installed_topic
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.offline.graph_stages import graph_stages
from friction_bags.offline.plan import ProcessOptions, SayOnce, open_bag, output_numbers, plan_for
from friction_bags.offline.stage_processes import read_steps, steps_of_stages, undecoded
from friction_bags.offline.stage_run import StageRun
from vehicle_models.nanoseconds import NANOSECOND

_CHUNK_SIZE = 4 << 20
_PROGRESS_EVERY = 1000
_number = itemgetter(0)


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
        found = tuple(dict.fromkeys([*reader.problems, *problems, *undecoded(run)]))
        return ProcessResult(str(bag), count, given, duration, perf_counter() - begun, found)
