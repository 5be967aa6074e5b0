"""Lateral forces of the axles: force and moment of the car, delay of the signals, and the signs of a slide."""

import numpy as np
import pytest

from vehicle_models.lateral_forces import GYRATION, AxleForces, LateralForces, Sideslip
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("compact_car")


@pytest.mark.parametrize(("yaw_acceleration", "moment"), [(0.0, 0.0), (1.5, 0.0), (0.0, 900.0), (-2.0, 400.0)])
def test_the_axles_carry_the_car_sideways_and_turn_it(yaw_acceleration: float, moment: float) -> None:
    front, _, rear, _ = AxleForces(CAR).at(5.0, yaw_acceleration, moment)
    assert front + rear == pytest.approx(5.0 * CAR.mass)
    ahead, behind = CAR.wheelbase * (1.0 - CAR.front_load_share), CAR.wheelbase * CAR.front_load_share
    inertia = GYRATION * CAR.mass * ahead * behind
    assert ahead * front - behind * rear + moment == pytest.approx(inertia * yaw_acceleration)


def test_a_force_backwards_on_the_left_turns_the_car_to_the_left() -> None:
    assert AxleForces(CAR).lever == pytest.approx(np.array([1.0, -1.0, 1.0, -1.0]) * 0.5 * CAR.track)


def test_the_forces_of_samples_come_to_those_of_a_steady_curve() -> None:
    forces = LateralForces(CAR)
    for _ in range(200):
        forces.move(0.005, 0.3, 6.0, np.array([2000.0, 2500.0, 800.0, 900.0]))
    steady = AxleForces(CAR).at(6.0, 0.0, 0.5 * CAR.track * -600.0)
    assert forces.forces == pytest.approx(steady, rel=1e-6)


@pytest.mark.parametrize(("leftward", "slides"), [(5.0, False), (2.0, True)])
def test_a_car_slides_that_turns_without_the_force_to_do_so(leftward: float, slides: bool) -> None:
    sideslip = Sideslip()
    for _ in range(200):
        sideslip.move(0.005, 20.0, 0.25, leftward)
    assert sideslip.change == pytest.approx(leftward - 5.0)
    assert sideslip.slides is slides
    sideslip.begin_braking()
    assert not sideslip.slides
