"""Every message of a short drive with one hard braking: sensors, smart tyres, and the estimates made from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from corner_sim.parameters import SimParameters
from corner_sim.simulation import Simulation
from friction_bags.offline.estimators import ESTIMATORS, SMART_TYRE, closed_loop_parameters, make_processors
from friction_bringup.graph import plant_calibration
from friction_parameters.parameter import from_mapping
from friction_runtime.processor import silent
from friction_runtime.processor_graph import ProcessorGraph
from vehicle_models.vehicle import Vehicle

START = 10**12
"""Stamp of the first sample [ns]."""


def fuzzed_parameters() -> dict[str, Any]:
    """Return the parameters of the nodes, by name: the supervisor commands, and the tyres are calibrated."""
    found = closed_loop_parameters(ESTIMATORS)
    found[SMART_TYRE] = replace(found[SMART_TYRE], calibration_file=str(plant_calibration()))
    return found


def clean_run(vehicle: Vehicle, seconds: float) -> list[tuple[str, Any]]:
    """Return topics and messages in the order of the data flow.

    Args:
        vehicle: the car.
        seconds: length of the drive; braking begins after 0.5 s.
    """
    given = {
        "demand_level": 1.2,
        "demand_start": 0.5,
        "demand_rise": 0.3,
        "end_time": seconds,
        "acceleration_variance": 0.01,
        "tyre_signals": True,
        "vehicle_velocity": False,
    }
    simulation = Simulation(from_mapping(SimParameters, given), vehicle, START)
    graph = ProcessorGraph(make_processors(fuzzed_parameters(), vehicle, silent))
    run: list[tuple[str, Any]] = []
    while simulation.end is None:
        for topic, message in simulation.messages():
            if not topic.startswith("truth/"):
                run.append((topic, message))
                run.extend(graph.feed(topic, message))
        simulation.advance()
    return run


def inputs_of(processor: Any, run: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Return the part of a run that a processor takes."""
    topics = {*processor.sensors, *processor.estimates}
    return [(topic, message) for topic, message in run if topic in topics]
