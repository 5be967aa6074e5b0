"""The car in plain numbers is that of vehicle_models.two_axle to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from corner_sim.models import Car, in_order
from corner_sim.two_axle import TwoAxleCar
from vehicle_models.surfaces import surface
from vehicle_models.vehicle_file import load_vehicle

STEP = 5e-3


@pytest.mark.parametrize("vehicle", ["compact_car", "smart_tyre_car", "indy_av21"])
@pytest.mark.parametrize("road", [("dry",) * 4, ("snow", "dry", "wet", "cobblestone")])
def test_one_car_brakes_and_locks_as_the_many_do(vehicle: str, road: tuple[str, ...]) -> None:
    car_file = in_order("two_axle", load_vehicle(vehicle))
    theta = np.array([surface(name) for name in road])
    one, many = Car(car_file, 12.0), TwoAxleCar(car_file, [12.0])
    peak = one.peak_torque(theta[0])
    rng = np.random.default_rng(5)
    begin = np.zeros(4)
    locked = False
    for _ in range(800):
        end = np.maximum(begin + rng.uniform(-0.3, 0.4, 4) * peak, 0.0) % (2.5 * peak)
        one.step(begin, end, theta, STEP)
        many.step(begin, end, theta[np.newaxis], STEP)
        begin = end
        assert one.speed == many.speed[0]
        assert np.array_equal(one.wheel_speed, many.wheel_speed[0])
        assert np.array_equal(one.slip, many.slip[0])
        behind = [0.0, 0.0, car_file.wheelbase, car_file.wheelbase]
        assert np.array_equal(one.distance, many.distance[0] - behind)
        assert one.acceleration(theta) == many.acceleration(theta[np.newaxis])[0]
        assert np.array_equal(one.vertical_load(theta), many.wheel_loads(theta[np.newaxis])[0])
        assert np.array_equal(one.wheel_acceleration(theta, end), many.wheel_acceleration(theta[np.newaxis], end)[0])
        locked = locked or bool(np.any(one.wheel_speed == 0.0) and one.speed > 1.0)
    assert locked
    assert one.speed < 5.0
