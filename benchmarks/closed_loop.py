"""The shipped graph in the loop of a plant: its estimators and its supervisor, as fast as the machine can."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from friction_msgs.msg import BrakeCommand

from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import closed_loop_parameters
from friction_runtime.processor import Output, ProcessorGraph


def loop_parameters(estimators: Iterable[str], law: str) -> dict[str, Any]:
    """Return the parameters of estimators, abs_supervisor among them, which is under a law and follows no clock."""
    parameters = closed_loop_parameters(estimators, law)
    parameters["abs_supervisor"] = replace(parameters["abs_supervisor"], real_time=False)
    return parameters


def take_sample(simulation: Simulation, graph: ProcessorGraph) -> list[Output]:
    """Give the present sample to the graph and its commands to the plant; return all messages in order.

    Raises:
        RuntimeError: a wheel got no command for the sample: the loop is not closed.
    """
    heard: list[Output] = []
    for topic, message in simulation.messages():
        heard.append((topic, message))
        for name, answer in graph.feed(topic, message):
            heard.append((name, answer))
            if isinstance(answer, BrakeCommand):
                simulation.take_command(answer.wheel, answer)
    if simulation.unanswered:
        raise RuntimeError(f"no brake_command for {', '.join(simulation.unanswered)}")
    return heard
