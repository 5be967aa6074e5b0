"""Sensors that speak of one motion in different units are named, and nothing made from them is valid."""

from collections.abc import Callable
from copy import deepcopy
from math import isnan, pi
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import WheelSlip

from corner_sim.car.car_parameters import CarParameters
from corner_sim.car.driving import Cycling, SlipCycle
from corner_sim.car.recording import record
from corner_sim.car.tyres import TYRES
from corner_sim.parameters import SimParameters
from corner_sim.ros.simulation import Simulation
from friction_parameters.parameter import from_mapping
from sensor_monitor.unit_check import UnitCheck
from vehicle_models.reason import Reason
from vehicle_models.vehicle_file import load_vehicle
from wheel_slip.estimator import SlipEstimator
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.ros.processor import build

CAR = load_vehicle("chapter_car")
RADIUS = 0.3
STEP = 5_000_000
Change = Callable[[str, Any], None]


def drive(demand: float, speed_sensor: bool) -> list[tuple[str, Any]]:
    """Sensors of a car that rolls for half a second, then brakes gently."""
    given = {
        "demand_level": demand,
        "demand_start": 0.5,
        "demand_rise": 1.0,
        "end_time": 4.0,
        "acceleration_variance": 0.01,
        "vehicle_velocity": speed_sensor,
    }
    simulation = Simulation(from_mapping(SimParameters, given), CAR, 10**12)
    found = []
    while simulation.end is None:
        found += [(topic, message) for topic, message in simulation.messages() if not topic.startswith("truth/")]
        simulation.advance()
    return found


def answers(run: list[tuple[str, Any]], change: Change) -> list[WheelSlip]:
    processor = build(WheelSlipParameters(), CAR)[0]
    topics = {*processor.sensors, *processor.estimates}
    found = []
    for topic, message in run:
        if topic in topics:
            changed = deepcopy(message)
            change(topic, changed)
            found += [answer for _, answer in processor.process(topic, changed) if isinstance(answer, WheelSlip)]
    return found


def speed_times(factor: float) -> Change:
    def change(topic: str, message: Any) -> None:
        if topic == "vehicle_velocity":
            message.twist.twist.linear.x *= factor

    return change


def wheels_times(factor: float) -> Change:
    def change(topic: str, message: Any) -> None:
        if topic == "wheel_states":
            message.velocity = [speed * factor for speed in message.velocity]

    return change


def acceleration_times(factor: float) -> Change:
    def change(topic: str, message: Any) -> None:
        if topic == "imu/data":
            message.linear_acceleration.x *= factor

    return change


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (speed_times(3.6), "km/h"),
        (speed_times(2.237), "miles"),
        (wheels_times(30.0 / pi), "revolutions a minute"),
        (wheels_times(0.5 / pi), "revolutions a second"),
    ],
)
def test_speed_and_wheels_in_different_units_have_no_slip_from_the_first_sample_and_the_unit_is_named(
    change: Change, named: str
) -> None:
    found = answers(drive(0.3, speed_sensor=True), change)
    assert not [each for each in found if each.validity.valid]
    assert all(named in each.validity.text and isnan(each.vehicle_speed) for each in found[len(found) // 2 :])


@pytest.mark.parametrize(("factor", "named"), [(1.0 / 9.81, "in g"), (-1.0, "sign")])
def test_acceleration_in_g_or_of_the_wrong_sign_is_named_within_a_second_of_gentle_braking(
    factor: float, named: str
) -> None:
    found = answers(drive(0.3, speed_sensor=False), acceleration_times(factor))
    late = [each for each in found if each.header.stamp.sec >= 1002]
    assert late
    assert all(not each.validity.valid and named in each.validity.text for each in late)


@pytest.mark.parametrize("speed_sensor", [False, True])
@pytest.mark.parametrize("demand", [0.3, 1.2])
def test_a_healthy_car_is_never_suspected(demand: float, speed_sensor: bool) -> None:
    found = answers(drive(demand, speed_sensor), lambda topic, message: None)
    assert not [each.validity.text for each in found if each.validity.reason == Reason.BAD_INPUT]
    assert sum(each.validity.valid for each in found) > 0.8 * len(found)


@pytest.mark.parametrize("road", ["dry", "cobblestone", "snow"])
def test_a_car_whose_first_braking_cycles_its_slips_through_the_peak_is_not_suspected(road: str) -> None:
    car = CarParameters(tyres=(TYRES["burckhardt"][road],) * 4, relaxation_length=(0.3,) * 4)
    run = record(car, SlipCycle(car, Cycling(start=0.6)), seed=1, speed=25.0, duration=5.0)
    estimator = SlipEstimator(load_vehicle("compact_car"))
    named = set()
    for time, wheel_speeds, acceleration in zip(run.time, run.wheel_speed, run.acceleration, strict=True):
        answers = estimator.update(round(time * 1e9) + 10**9, wheel_speeds.tolist(), float(acceleration))
        named |= {answer.text for answer in answers if answer.reason is Reason.BAD_INPUT}
    assert not named


def test_wheels_that_agreed_once_may_all_slide_at_any_slip() -> None:
    check = UnitCheck(RADIUS)
    for k in range(100):
        check.update(k * STEP, (20.0, 20.0), (0.0, 0.0), None, 20.0)
    for k in range(100, 200):
        check.update(k * STEP, (20.0 / 3.6, 20.0 / 3.6), (0.0, 0.0), None, 20.0)
        assert check.text == ""


def test_a_suspicion_ends_once_the_sensors_agree_and_begins_again_after_a_reset() -> None:
    check = UnitCheck(RADIUS)
    check.update(0, (20.0,), (0.0,), None, 72.0)
    assert "km/h" in check.text
    check.update(STEP, (20.0,), (0.0,), None, 20.1)
    assert check.text == ""
    for k in range(2, 100):
        check.update(k * STEP, (20.0,), (0.0,), None, 20.0)
    check.reset()
    check.update(0, (20.0,), (0.0,), None, 72.0)
    assert "km/h" in check.text


def test_noise_between_accelerations_that_do_not_change_says_nothing() -> None:
    rng = np.random.default_rng(3)
    check = UnitCheck(RADIUS)
    for k in range(4000):
        check.update(k * STEP, (20.0, 20.0), tuple(rng.normal(0.0, 0.3, 2)), -float(rng.normal(0.0, 1.0)), None)
        assert check.text == ""
