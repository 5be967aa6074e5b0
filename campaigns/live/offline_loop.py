"""The closed loop without middleware: the shipped processors around the plant's simulation, in one process."""

from __future__ import annotations

from collections.abc import Sequence

from corner_sim.simulation import Simulation
from friction_bags.bag_io.cdr import encode
from friction_runtime.processor import Processor
from friction_runtime.processor_graph import ProcessorGraph


def run_offline(simulation: Simulation, processors: Sequence[Processor]) -> dict[str, list[bytes]]:
    """Run the simulation to its end with the processors in the loop.

    Args:
        simulation: the plant, at its first sample.
        processors: all that take part, in any order.

    Returns:
        Every message of the run, encoded, by topic, in order.

    Raises:
        RuntimeError: a sample stays without brake_command: the loop is not closed.
    """
    graph = ProcessorGraph(processors)
    found: dict[str, list[bytes]] = {}
    while True:
        for topic, message in simulation.messages():
            for name, each in ((topic, message), *graph.feed(topic, message)):
                found.setdefault(name, []).append(encode(each))
                if name.endswith("/brake_command"):
                    simulation.take_command(each.wheel, each)
        if simulation.end is not None:
            return found
        if simulation.unanswered:
            raise RuntimeError(
                f"no brake_command at stamp {simulation.stamp} ns for {', '.join(simulation.unanswered)}"
            )
        simulation.advance()
