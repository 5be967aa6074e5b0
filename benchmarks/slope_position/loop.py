"""Signs in stops of the whole graph: its supervisor brakes, so that slips are held around the peak."""

from typing import Final

import numpy as np
from friction_msgs.msg import FrictionSlope

from benchmarks.closed_loop import loop_parameters, take_sample
from benchmarks.cycled_stops import LEAST_SPEED, VEHICLE
from benchmarks.protocol import ACCELERATION_OFFSET, ACCELERATION_STDDEV, SPEED
from benchmarks.slope_position.stops import Case, Stop, Told, note, sign_tables
from corner_sim.car_plant import CAR, in_order
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, make_processors
from friction_runtime.processor import ProcessorGraph, silent
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle

LAWS: Final = ("curve", "slope_sign")
AXLES: Final = ("front", "rear")
DEMAND: Final = 1.5
"""[-] of the torque at the peak."""
ROLLS: Final = 3.0
"""Time before the brakes [s]."""
LONGEST: Final = 40.0
"""Time after which a stop ends [s]."""


def loop_cases(law: str, road: str) -> tuple[Case, Case]:
    """Return the cases of the front and of the rear wheels."""
    front, rear = (Case(f"closed loop, {law}, {road}, {axle}", road) for axle in AXLES)
    return front, rear


def make_loop(job: tuple[str, str, int]) -> tuple[Stop, Stop]:
    """Brake once under a law, on a road, with a seed; return what was told of the front and of the rear wheels.

    Raises:
        RuntimeError: the supervisor did not answer a sample.
    """
    law, road, seed = job
    vehicle = in_order(load_vehicle(VEHICLE))
    wheels = vehicle.wheel_names
    graph = ProcessorGraph(make_processors(loop_parameters(WHEEL_ESTIMATORS, law), vehicle, silent))
    plant = SimParameters(
        model=CAR,
        initial_speed=SPEED,
        surfaces=(road,),
        surface_distances=(0.0,),
        demand_unit="peak_ratio",
        demand_level=DEMAND,
        demand_start=ROLLS,
        acceleration_variance=ACCELERATION_STDDEV**2,
        acceleration_bias=ACCELERATION_OFFSET,
        vehicle_velocity=False,
        seed=seed,
    )
    simulation = Simulation(plant, vehicle, NANOSECONDS)
    told: Told = {}
    stamps: list[int] = []
    beyond: list[list[bool]] = []
    judged: list[bool] = []
    while simulation.end is None and simulation.time < ROLLS + LONGEST:
        sample = simulation.sample
        stamps.append(simulation.stamp)
        beyond.append((sample.tyre_slip > sample.peak[:, 0]).tolist())
        judged.append(simulation.time > ROLLS + 0.1 and simulation.speed > LEAST_SPEED)
        for topic, message in take_sample(simulation, graph):
            if isinstance(message, FrictionSlope) and not topic.startswith("truth/"):
                note(message, told)
        simulation.advance()
    time = np.array(stamps) / NANOSECONDS
    told_at, sign = sign_tables(time, stamps, wheels, told)
    front, rear = (
        Stop(time, np.array(beyond)[:, axle], np.array(judged), sign[:, axle], told_at[:, axle])
        for axle in (slice(0, 2), slice(2, 4))
    )
    return front, rear
