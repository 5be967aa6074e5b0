"""Panic stops of a car with four wheels to standstill, the shipped graph in the loop."""

from dataclasses import fields, replace

import numpy as np
from friction_msgs.msg import BrakeCommand

from benchmarks.closed_loop.car_setup import CarSetup
from benchmarks.closed_loop.law_stops import ROLLING
from benchmarks.closed_loop.longest_lock import LongestLock
from benchmarks.closed_loop.panic_plant import Array
from benchmarks.closed_loop.panic_stop import END_SPEED, LOCK_ABOVE, LONGEST, PanicStops
from corner_sim.plant import SAMPLE_TIME
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, closed_loop_parameters, make_processors
from friction_runtime.processor import Processor, silent
from friction_runtime.processor_graph import ProcessorGraph


def car_stops(setup: CarSetup, seeds: range, law: str) -> PanicStops:
    """Brake once for each seed, of the sensor noise and of the road, under a law of abs_supervisor.

    Utilisation is that of the tyres: their braking forces over those of their peaks. The longest lock is that of any
    wheel, the changes of the command are a mean of the wheels.
    """
    found = [car_stop(setup, seed, law)[0] for seed in seeds]
    columns = {each.name: np.concatenate([getattr(stop, each.name) for stop in found]) for each in fields(PanicStops)}
    return PanicStops(**columns)


def car_stop(setup: CarSetup, seed: int, law: str) -> tuple[PanicStops, Array]:
    """Brake once; return the result, and the moment about the vertical from the onset on [N m], shape (k,)."""
    wheels = setup.told.wheel_names
    graph = ProcessorGraph(_processors(law, setup))
    simulation = setup.simulation(seed)
    lock = LongestLock(len(wheels))
    slip, force = np.zeros(len(wheels)), np.zeros(len(wheels))
    commands = np.ones(len(wheels), dtype=np.int64)
    before = commands.copy()
    used: list[float] = []
    moments: list[float] = []
    changes, fast, start = 0, 0, 0.0
    while simulation.end is None and simulation.time < ROLLING * SAMPLE_TIME + LONGEST:
        braking = simulation.index >= ROLLING
        for topic, message in simulation.messages():
            if topic.startswith("truth/"):
                if topic.endswith("/slip"):
                    slip[wheels.index(message.wheel)] = message.slip
                elif topic.endswith("/tyre_force"):
                    force[wheels.index(message.wheel)] = -message.fx
                continue
            for _, each in graph.feed(topic, message):
                if isinstance(each, BrakeCommand):
                    simulation.take_command(each.wheel, each)
                    commands[wheels.index(each.wheel)] = each.command
        if simulation.unanswered:
            raise RuntimeError(f"no brake_command for {', '.join(simulation.unanswered)}")
        if simulation.index == ROLLING:
            start = simulation.distance
        if braking:
            sample = simulation.sample
            used.append(float(force.sum() / (sample.vertical_load @ sample.peak[:, 1])))
            moments.append(sample.yaw_moment)
            lock.update(np.nan_to_num(slip), np.full(len(wheels), simulation.speed > LOCK_ABOVE))
            if simulation.speed > END_SPEED:
                fast += 1
                changes += int((commands != before).sum())
        before = commands.copy()
        simulation.advance()
    found = PanicStops(
        utilisation=np.array([np.mean(used[:fast])]),
        utilisation_to_rest=np.array([np.mean(used)]),
        distance=np.array([simulation.distance - start]),
        longest_lock=lock.longest.max(keepdims=True),
        changes=np.array([changes / len(wheels) / (fast * SAMPLE_TIME)]),
        stopped=np.array([simulation.end is not None]),
    )
    return found, np.array(moments)


def _processors(law: str, setup: CarSetup) -> list[Processor]:
    told = setup.told
    parameters = closed_loop_parameters(WHEEL_ESTIMATORS, law, len(told.wheels))
    supervisor = replace(parameters["abs_supervisor"], real_time=False, select_low=setup.select_low)
    parameters["abs_supervisor"] = supervisor
    return make_processors(parameters, told, silent)
