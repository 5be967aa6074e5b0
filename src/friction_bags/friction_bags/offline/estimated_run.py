"""Runs the estimators over a bag and returns what they make as arrays, without a bag of it."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

from friction_bags.bag_io.cdr import type_name
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.offline.plan import ProcessOptions, SayOnce, open_bag, plan_for
from friction_bags.offline.run import ProcessResult, fed, not_decoded
from friction_bags.results.recorded_run import RecordedRun
from friction_bags.results.run_reader import RunCollector
from friction_runtime.processor import ProcessorGraph
from vehicle_models.nanoseconds import NANOSECOND


def estimated_run(bag: Path, options: ProcessOptions) -> tuple[ProcessResult, RecordedRun]:
    """Return the outputs of the estimators: the run that `read_run` reads from the bag of `process_bag`.

    The topics of the bag are left out, as with `outputs_only`. All is done in this process.

    Args:
        bag: bag to read.
        options: options of the user.

    Raises:
        BagError: the bag cannot be read, holds no wheel of the car, or nothing is estimated.
        ParameterError: a parameter or the vehicle file is bad, or no car is named.
    """
    begun = perf_counter()
    say = SayOnce()
    with open_bag(bag, options.map_file, options.vehicle, options.prefix, say) as reader:
        plan, processors = plan_for(reader, options, say)
        graph, collector = ProcessorGraph(tuple(processors)), RunCollector()
        made = {topic: kind for processor in processors for topic, kind in processor.outputs.items()}
        shown = {topic for topic, kind in made.items() if collector.adds(topic, type_name(kind))}
        taken = {topic: name for topic, name in zip(reader.counts, plan.taken, strict=True) if name}
        refused: dict[str, int] = {}
        count = given = 0
        for topic, _, data in reader.messages(taken):
            count += 1
            for output, answer in fed(graph, taken[topic], data, refused):
                given += 1
                if output in shown:
                    collector.take(output, answer)
        problems = tuple(dict.fromkeys([*reader.problems, *not_decoded(refused)]))
        duration = (reader.end - reader.start) * NANOSECOND
        result = ProcessResult(str(bag), count, given, duration, perf_counter() - begun, problems)
        return result, collector.run(None, {**reader.custom_data, VEHICLE_NOTE: plan.vehicle_note})
