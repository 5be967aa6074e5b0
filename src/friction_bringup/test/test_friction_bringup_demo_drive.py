"""The drive of the demo: the car reaches its speed within the grip it may use, and then stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand, FrictionSlope

from corner_sim.car_plant import in_order
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_bags.offline.estimators import WHEEL_ESTIMATORS, closed_loop_parameters, make_processors
from friction_bringup.demo_drive import CARS, ROADS, plant_of_demo
from friction_bringup.graph import PLANT
from friction_parameters.parameter import ParameterError, from_mapping
from friction_report.braking_metrics import right_signs
from friction_runtime.messages import to_nanoseconds
from friction_runtime.processor import ProcessorGraph, silent
from vehicle_models import burckhardt
from vehicle_models.vehicle_file import load_vehicle


def plant(road: str, car: str = "car") -> Mapping[str, Any]:
    return plant_of_demo(road, CARS[car])[PLANT]


@pytest.mark.parametrize("road", ["dry", "snow"])
def test_car_rolls_for_its_zero_then_drives_up_with_at_most_half_of_the_grip(road: str) -> None:
    given = replace(from_mapping(SimParameters, plant(road)), tyre_signals=False)
    simulation = Simulation(given, in_order(load_vehicle(CARS["car"])), 10**12)
    speeds, used = [], []
    while simulation.time < given.demand_start:
        sample = simulation.sample
        speeds.append(sample.speed)
        used.append(np.max(np.abs(sample.friction) / sample.peak[:, 1]))
        simulation.advance()
    rolling = np.array(speeds[:1000])
    assert rolling.max() / rolling.min() < 1.03  # what the smart tyre takes for a constant speed
    assert speeds[0] == 8.0
    assert speeds[-1] == pytest.approx(22.0, rel=0.02)
    assert max(used) <= 0.5


@pytest.mark.parametrize("road", [*ROADS, "1.1,30,0.4"])
def test_every_road_makes_a_plant(road: str) -> None:
    Simulation(from_mapping(SimParameters, plant(road)), in_order(load_vehicle(CARS["car"])), 10**12)


def test_own_road_has_the_peak_of_its_theta_under_either_car() -> None:
    theta = np.array([1.1, 30.0, 0.4])
    for car in CARS:
        given = replace(from_mapping(SimParameters, plant("1.1,30,0.4", car)), tyre_signals=False)
        sample = Simulation(
            given, in_order(load_vehicle(CARS[car])) if car == "car" else load_vehicle(CARS[car]), 1
        ).sample
        assert sample.peak[0] == pytest.approx([float(each) for each in burckhardt.peak(theta)])


@pytest.mark.parametrize("road", ["ice", "off_road", "1.1,30", "1.1,30,nan", "1.1,0.1,0.4"])
def test_road_that_is_none_is_refused_with_those_there_are(road: str) -> None:
    with pytest.raises(ParameterError, match=r"dry.*or theta"):
        plant(road)


def test_second_road_begins_while_the_car_brakes() -> None:
    given = replace(from_mapping(SimParameters, plant("dry snow")), tyre_signals=False)
    simulation = Simulation(given, in_order(load_vehicle(CARS["car"])), 10**12)
    while simulation.time < given.demand_start:
        simulation.advance()
    assert 5.0 < given.surface_distances[1] - simulation.distance < 20.0


def test_valid_slope_signs_of_the_sign_law_are_the_true_ones() -> None:
    """ABS from 22 m/s on dry, whose slip crosses the peak every 0.15 to 0.3 s: H cannot tell it all the time."""
    onset = 1.0
    given = dict(plant("dry")) | {"initial_speed": 22.0, "tyre_signals": False, "demand_start": onset}
    given |= {"car.drive_times": [0.0], "car.drive_speeds": [22.0], "lock_step": True}
    vehicle = in_order(load_vehicle(CARS["car"]))
    simulation = Simulation(from_mapping(SimParameters, given), vehicle, 10**12)
    processors = make_processors(closed_loop_parameters(WHEEL_ESTIMATORS), vehicle, silent)
    graph = ProcessorGraph(processors)
    signs: dict[str, list[tuple[float, ...]]] = {wheel: [] for wheel in vehicle.wheel_names}
    truth: list[tuple[float, ...]] = []
    while simulation.time < onset + 1.8:
        truth.append((simulation.stamp, *np.where(simulation.sample.slope < 0.0, -1, 1)))
        for topic, message in simulation.messages():
            if topic.startswith("truth/"):
                continue
            for _, answer in graph.feed(topic, message):
                if isinstance(answer, BrakeCommand):
                    simulation.take_command(answer.wheel, answer)
                if isinstance(answer, FrictionSlope):
                    stamp = to_nanoseconds(answer.header.stamp)
                    signs[answer.wheel].append((stamp, answer.sign, answer.validity.valid, 1e9 * answer.delay))
        simulation.advance()
    times, *of_wheels = np.array(truth, dtype=float).T
    counts = []
    for found, true in zip(signs.values(), of_wheels, strict=True):
        time, sign, valid, delay = np.array(found, dtype=float).T
        counts.append(right_signs(time, sign, valid > 0.0, delay, times, true))
    valid_signs, right = np.sum(counts, axis=0)
    assert right >= 0.9 * valid_signs
    assert valid_signs >= 0.15 * 4 * 1.8 / 0.005


def test_corner_has_no_sides_and_is_told_so() -> None:
    assert plant("wet", "corner") == {"surfaces": ["wet"]}
    with pytest.raises(ParameterError, match="'split' needs a car with four wheels"):
        plant("split", "corner")
